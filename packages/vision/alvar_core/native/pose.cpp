// pose.solve: both poses of a square, as "Infinitesimal Plane-Based Pose Estimation" has them
// (Collins and Bartoli, 2014; the method of OpenCV's SOLVEPNP_IPPE_SQUARE), then one Gauss-Newton step.
#include <algorithm>

#include "algebra.h"
#include "steps.h"

namespace {

using namespace alvar;

const double kUnitCorners[4][2] = {{-0.5, 0.5}, {0.5, 0.5}, {0.5, -0.5}, {-0.5, -0.5}};  // drawing.UNIT_CORNERS

// The position [widths] of a square with a rotation that fits rays (4, 2) best. False if there is none.
bool place(const double* rays, const double* r, double* position) {
    double normal[9] = {}, right[3] = {};
    for (int k = 0; k < 4; ++k) {
        const double x = kUnitCorners[k][0], y = kUnitCorners[k][1];
        const double p[3] = {r[0] * x + r[1] * y, r[3] * x + r[4] * y, r[6] * x + r[7] * y};
        for (int axis = 0; axis < 2; ++axis) {  // p + t lies on the ray: (p + t)[axis] = ray (p + t)[2]
            const double ray = rays[2 * k + axis], off = ray * p[2] - p[axis];
            double row[3] = {0, 0, -ray};
            row[axis] = 1;
            for (int i = 0; i < 3; ++i) {
                right[i] += row[i] * off;
                for (int j = 0; j < 3; ++j) normal[3 * i + j] += row[i] * row[j];
            }
        }
    }
    std::copy(right, right + 3, position);
    return solve(normal, position, 3, 1);
}

// The rotations of a square seen along rays (4, 2), y down in the image: those with one sign and with the other.
bool rotations_of(const double* rays, double (*out)[9]) {
    double h[9];
    from_square(rays, 0.5, h);
    // of places with y up
    const double p = h[2], q = h[5];
    const double j[4] = {h[0] - h[6] * p, -(h[1] - h[7] * p), h[3] - h[6] * q, -(h[4] - h[7] * q)};
    // the rotation of the optical axis to the ray of the middle
    const double t = std::sqrt(p * p + q * q + 1), c = 1 / t, a = 1 / (t * (t + 1));
    const double to_ray[9] = {1 - p * p * a, -p * q * a, p * c, -p * q * a, 1 - q * q * a, q * c, -p * c, -q * c, c};
    const double b[4] = {to_ray[0] - p * to_ray[6], to_ray[1] - p * to_ray[7], to_ray[3] - q * to_ray[6],
                         to_ray[4] - q * to_ray[7]};
    const double det = b[0] * b[3] - b[1] * b[2];
    double m[4] = {(b[3] * j[0] - b[1] * j[2]) / det, (b[3] * j[1] - b[1] * j[3]) / det,
                   (b[0] * j[2] - b[2] * j[0]) / det, (b[0] * j[3] - b[2] * j[1]) / det};
    const double squares = m[0] * m[0] + m[1] * m[1] + m[2] * m[2] + m[3] * m[3];
    const double product = m[0] * m[3] - m[1] * m[2];
    const double gamma = std::sqrt(0.5 * (squares + std::sqrt(std::max(squares * squares - 4 * product * product, 0.0))));
    if (!(gamma > 0) || !std::isfinite(gamma)) return false;
    for (double& each : m) each /= gamma;
    const double across = std::sqrt(std::max(1 - m[0] * m[0] - m[2] * m[2], 0.0));
    double up = std::sqrt(std::max(1 - m[1] * m[1] - m[3] * m[3], 0.0));
    if (m[0] * m[1] + m[2] * m[3] > 0) up = -up;
    for (int k = 0; k < 2; ++k) {
        const double sign = k ? -1 : 1, x[3] = {m[0], m[2], sign * across}, y[3] = {m[1], m[3], sign * up};
        const double own[9] = {x[0], y[0], x[1] * y[2] - x[2] * y[1], x[1], y[1], x[2] * y[0] - x[0] * y[2],
                               x[2], y[2], x[0] * y[1] - x[1] * y[0]};
        multiply(to_ray, own, out[k], 3, 3, 3);
    }
    return true;
}

// The rotation matrix of a turn [rad] about the axis of a vector, by Rodrigues' formula
void turn_matrix(const double* v, double* out) {
    const double angle = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    const double s = angle < 1e-9 ? 1 : std::sin(angle) / angle;
    const double c = angle < 1e-9 ? 0.5 : (1 - std::cos(angle)) / (angle * angle);
    const double x = v[0], y = v[1], z = v[2];
    const double rows[9] = {1 - c * (y * y + z * z), c * x * y - s * z, c * x * z + s * y,
                            c * x * y + s * z, 1 - c * (x * x + z * z), c * y * z - s * x,
                            c * x * z - s * y, c * y * z + s * x, 1 - c * (x * x + y * y)};
    std::copy(rows, rows + 9, out);
}

// Sets error and chi2; with a jacobian (8, 6), also that of the residual by a small turn and a shift.
void judge(const double* corners, const Lens& lens, const double* information, double size, Solution& s,
           double* residual, double (*jacobian)[6]) {
    double squares = 0;
    for (int k = 0; k < 4; ++k) {
        const double x = kUnitCorners[k][0] * size, y = kUnitCorners[k][1] * size, *r = s.rotation[0];
        const double p[3] = {r[0] * x + r[1] * y, r[3] * x + r[4] * y, r[6] * x + r[7] * y};
        const double z = p[2] + s.position[2], u = (p[0] + s.position[0]) / z, v = (p[1] + s.position[1]) / z;
        residual[2 * k] = u * lens.fx + lens.cx - corners[2 * k];
        residual[2 * k + 1] = v * lens.fy + lens.cy - corners[2 * k + 1];
        squares += residual[2 * k] * residual[2 * k] + residual[2 * k + 1] * residual[2 * k + 1];
        if (!jacobian) continue;
        for (int axis = 0; axis < 2; ++axis) {
            const double focal = axis ? lens.fy : lens.fx, scale = focal / z;
            const double shift[3] = {axis ? 0 : scale, axis ? scale : 0, -scale * (axis ? v : u)};
            double* row = jacobian[2 * k + axis];
            // a turn t moves p by t x p
            row[0] = shift[2] * p[1] - shift[1] * p[2];
            row[1] = shift[0] * p[2] - shift[2] * p[0];
            row[2] = shift[1] * p[0] - shift[0] * p[1];
            std::copy(shift, shift + 3, row + 3);
        }
    }
    s.error = std::sqrt(squares / 4), s.chi2 = 0;
    for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j) s.chi2 += residual[i] * information[8 * i + j] * residual[j];
}

// One Gauss-Newton step, where it makes chi2 smaller.
void refine(const double* corners, const Lens& lens, const double* information, double size, Solution& s) {
    double residual[8], jacobian[8][6], weighted[6][8], normal[36], step[6] = {};
    judge(corners, lens, information, size, s, residual, jacobian);
    for (int i = 0; i < 6; ++i)
        for (int k = 0; k < 8; ++k) {
            weighted[i][k] = 0;
            for (int l = 0; l < 8; ++l) weighted[i][k] += jacobian[l][i] * information[8 * l + k];
            step[i] -= weighted[i][k] * residual[k];
        }
    for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j) {
            double sum = 0;
            for (int k = 0; k < 8; ++k) sum += weighted[i][k] * jacobian[k][j];
            normal[6 * i + j] = i == j ? sum * (1 + 1e-4) : sum;
        }
    if (!solve(normal, step, 6, 1)) return;
    Solution after;
    double turn[9];
    turn_matrix(step, turn);
    multiply(turn, s.rotation[0], after.rotation[0], 3, 3, 3);
    for (int i = 0; i < 3; ++i) after.position[i] = s.position[i] + step[3 + i];
    judge(corners, lens, information, size, after, residual, nullptr);
    if (after.position[2] > 0 && after.chi2 <= s.chi2) s = after;
}

}  // namespace

int alvar::solve_pose(const double* corners, double size, const Lens& lens, const double* information,
                      Solution* solutions) {
    double rays[8], rotations[2][9];
    for (int k = 0; k < 4; ++k) {
        rays[2 * k] = (corners[2 * k] - lens.cx) / lens.fx;
        rays[2 * k + 1] = (corners[2 * k + 1] - lens.cy) / lens.fy;
    }
    int count = 0;
    if (rotations_of(rays, rotations))
        for (const double* rotation : rotations) {
            Solution& s = solutions[count];
            std::copy(rotation, rotation + 9, s.rotation[0]);
            if (!place(rays, rotation, s.position) || !(s.position[2] > 0)) continue;
            for (double& each : s.position) each *= size;
            refine(corners, lens, information, size, s);
            count += std::isfinite(s.chi2) && std::isfinite(s.rotation[0][0]);
        }
    if (count == 2 && solutions[1].chi2 < solutions[0].chi2) std::swap(solutions[0], solutions[1]);
    return count;
}
