// bent_paper: where a marker on curved paper is in the image
#pragma once
#include "algebra.h"
#include "steps.h"

namespace alvar {

// An edge point in the image: place and direction across the edge [ideal px], derivatives of the place along it
constexpr int kMostFree = 9;
struct SeenEdge {
    double u, v, du, dv, row[kMostFree];
};

// The direction, of length 1, at a right angle to an edge, on the side of `out`.
inline void set_direction(double along_u, double along_v, double out_u, double out_v, SeenEdge& seen) {
    const double side = out_v * along_u - out_u * along_v;
    const double length = std::sqrt(along_u * along_u + along_v * along_v) + 1e-12;
    const double sign = (side > 0) - (side < 0);
    seen.du = -along_v * sign / length, seen.dv = along_u * sign / length;
}

// A marker bent as a cylinder (parameters: rotation vector, position [widths], bend, axis [rad]), or folded once
// (..., fold, direction across the crease [rad], its distance from the middle [widths]).
class Curved {
public:
    Curved(const Lens& lens, int cells, int count) : lens_(lens), cells_(cells), count_(count) {}

    void set(const double* theta) {
        set_rotation(theta);
        for (int i = 0; i < 3; ++i) position_[i] = theta[3 + i];
        for (int k = 0; k <= count_ - kPose; ++k) {
            double shape[kMostFree - kPose] = {};
            for (int i = kPose; i < count_; ++i) shape[i - kPose] = theta[i] + (i - kPose == k - 1 ? kStep : 0);
            papers_[k].set(shape, count_ == kPose + 3);
        }
    }

    // The place (2,) [ideal px] of a point [cells]
    void place(double x, double y, double* out) const {
        double paper[3], at[3];
        papers_[0].place(x / cells_, -y / cells_, paper);
        to_camera(paper, at);
        out[0] = at[0] / at[2] * lens_.fx + lens_.cx, out[1] = at[1] / at[2] * lens_.fy + lens_.cy;
    }

    SeenEdge edge(double x, double y, double right, double down) const {
        const double s = x / cells_, t = -y / cells_;
        double paper[3], at[3], way[3], turned[3], along[2], outward[2];
        SeenEdge seen;
        papers_[0].place(s, t, paper);
        to_camera(paper, at);
        const double depth = at[2], ray[2] = {at[0] / depth, at[1] / depth}, focal[2] = {lens_.fx, lens_.fy};
        papers_[0].way(s, t, down / cells_, right / cells_, way), multiply(turn_, way, turned, 3, 3, 1);
        for (int i = 0; i < 2; ++i) along[i] = focal[i] * (turned[i] - ray[i] * turned[2]);
        papers_[0].way(s, t, right / cells_, -down / cells_, way), multiply(turn_, way, turned, 3, 3, 1);
        for (int i = 0; i < 2; ++i) outward[i] = focal[i] * (turned[i] - ray[i] * turned[2]);
        seen.u = ray[0] * focal[0] + lens_.cx, seen.v = ray[1] * focal[1] + lens_.cy;
        set_direction(along[0], along[1], outward[0], outward[1], seen);
        double towards[3] = {seen.du * focal[0] / depth, seen.dv * focal[1] / depth, 0};
        towards[2] = -(towards[0] * ray[0] + towards[1] * ray[1]);
        for (int k = 0; k < 3; ++k) {
            multiply(by_turn_[k], paper, turned, 3, 3, 1);
            seen.row[k] = turned[0] * towards[0] + turned[1] * towards[1] + turned[2] * towards[2];
            seen.row[3 + k] = towards[k];
        }
        for (int k = kPose; k < count_; ++k) {
            double moved[3];
            papers_[k - kPose + 1].place(s, t, moved);
            for (int i = 0; i < 3; ++i) moved[i] = (moved[i] - paper[i]) / kStep;
            multiply(turn_, moved, turned, 3, 3, 1);
            seen.row[k] = turned[0] * towards[0] + turned[1] * towards[1] + turned[2] * towards[2];
        }
        return seen;
    }

private:
    static constexpr int kPose = 6;
    static constexpr double kStep = 1e-3;  // rad, for the derivatives by the shape

    // The paper in its own frame [widths]; z points towards the camera.
    struct Paper {
        double bend, c, n, offset, bend_c, bend_n;
        bool crease;

        void set(const double* shape, bool folded) {
            bend = shape[0], c = std::cos(shape[1]), n = std::sin(shape[1]), offset = shape[2], crease = folded;
            bend_c = std::cos(bend), bend_n = std::sin(bend);
        }
        void place(double s, double t, double* out) const {
            const double arc = s * c + t * n, v = t * c - s * n;
            double u = arc, z = 0;
            if (crease) {
                const double beyond = std::max(arc - offset, 0.0);
                u = std::min(arc, offset) + beyond * bend_c, z = -beyond * bend_n;
            } else if (std::fabs(bend) > 1e-9) {
                const double half = std::sin(bend * arc / 2);
                u = std::sin(bend * arc) / bend, z = -2 * half * half / bend;
            }
            out[0] = u * c - v * n, out[1] = u * n + v * c, out[2] = z;
        }
        // The derivative of the place by a way (ds, dt) on the paper
        void way(double s, double t, double ds, double dt, double* out) const {
            const double arc = s * c + t * n, along = ds * c + dt * n, beside = dt * c - ds * n;
            const bool folded = crease && arc > offset;
            const double turn_c = crease ? (folded ? bend_c : 1) : std::cos(bend * arc);
            const double turn_n = crease ? (folded ? bend_n : 0) : std::sin(bend * arc);
            const double rising = turn_c * along;
            out[0] = rising * c - beside * n, out[1] = rising * n + beside * c, out[2] = -turn_n * along;
        }
    };

    void to_camera(const double* paper, double* at) const {
        multiply(turn_, paper, at, 3, 3, 1);
        for (int i = 0; i < 3; ++i) at[i] += position_[i];
    }

    static void cross_matrix(const double* v, double* out) {
        const double rows[9] = {0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0};
        std::copy_n(rows, 9, out);
    }

    // The rotation of a rotation vector (Rodrigues) and its derivatives (Gallego and Yezzi 2015)
    void set_rotation(const double* r) {
        const double square = r[0] * r[0] + r[1] * r[1] + r[2] * r[2], angle = std::sqrt(square);
        const bool small = angle < 1e-9;
        const double by = small ? 1 : std::sin(angle) / angle, more = small ? 0.5 : (1 - std::cos(angle)) / square;
        double cross[9];
        cross_matrix(r, cross);
        multiply(cross, cross, turn_, 3, 3, 3);
        for (int i = 0; i < 9; ++i) turn_[i] = (i % 4 == 0) + by * cross[i] + more * turn_[i];
        for (int k = 0; k < 3; ++k) {
            double left[3], axis[3], both[9];
            for (int i = 0; i < 3; ++i) left[i] = (i == k) - turn_[3 * i + k];
            axis[0] = r[1] * left[2] - r[2] * left[1], axis[1] = r[2] * left[0] - r[0] * left[2];
            axis[2] = r[0] * left[1] - r[1] * left[0];
            for (int i = 0; i < 3; ++i) axis[i] = small ? i == k : (r[k] * r[i] + axis[i]) / square;
            cross_matrix(axis, both);
            multiply(both, turn_, by_turn_[k], 3, 3, 3);
        }
    }

    const Lens& lens_;
    int cells_, count_;
    double turn_[9], by_turn_[3][9], position_[3];
    Paper papers_[1 + kMostFree - kPose];  // as it is, then with each parameter of its shape a step larger
};

}  // namespace alvar
