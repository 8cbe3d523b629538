// edge_alignment.edge_points and the fits of a flat marker (edge_alignment.fit_plane) and of one on curved paper
// (bent_paper.fit_curved) to the edges of its cells
#include <limits>

#include "algebra.h"
#include "curved.h"
#include "steps.h"

namespace {

using namespace alvar;

constexpr int kAcross = 15, kEnds = 3;
constexpr int kRead = 16;  // one more, which is not used: then eight are read at once

// A flat marker at small changes of a homography
class Flat {
public:
    explicit Flat(const double* start) : start_(start) {}

    void set(const double* theta) {
        const double small[9] = {1 + theta[1], theta[2],  theta[0], theta[4], 1 + theta[5],
                                 theta[3],     -theta[6], -theta[7], 1};
        multiply(start_, small, h_, 3, 3, 3);
    }

    SeenEdge edge(double x, double y, double right, double down) const {
        const double* h = h_;
        const double w = h[6] * x + h[7] * y + h[8];
        const double u = (h[0] * x + h[1] * y + h[2]) / w, v = (h[3] * x + h[4] * y + h[5]) / w;
        const double far_out = h[6] * right + h[7] * down, far_along = h[6] * down - h[7] * right;
        const double out_u = h[0] * right + h[1] * down - u * far_out;
        const double out_v = h[3] * right + h[4] * down - v * far_out;
        const double along_u = h[0] * down - h[1] * right - u * far_along;
        const double along_v = h[3] * down - h[4] * right - v * far_along;
        SeenEdge seen;
        seen.u = u, seen.v = v;
        set_direction(along_u, along_v, out_u, out_v, seen);
        const double du = seen.du, dv = seen.dv, dw = -(du * u + dv * v);
        const double by_x = (start_[0] * du + start_[3] * dv + start_[6] * dw) / w;
        const double by_y = (start_[1] * du + start_[4] * dv + start_[7] * dw) / w;
        const double by_w = (start_[2] * du + start_[5] * dv + start_[8] * dw) / w;
        const double row[8] = {by_x, by_x * x, by_x * y, by_y, by_y * x, by_y * y, -by_w * x, -by_w * y};
        std::copy_n(row, 8, seen.row);
        return seen;
    }

private:
    const double* start_;
    double h_[9];
};

struct Fit {
    const int free;  // parameters
    std::vector<double> jacobian, offset, size, weight, sorted, weighted;  // (free, count), (count,)
    std::vector<char> good;

    Fit(int count, int parameters)
        : free(parameters), jacobian(count * free), offset(count), size(count), weight(count), sorted(count), weighted(count),
          good(count) {}

    // The typical size of a residual; sets the weights.
    double weigh(int count, int middle, const Thresholds& limit) {
        for (int i = 0; i < count; ++i) sorted[i] = good[i] ? size[i] : std::numeric_limits<double>::infinity();
        const double error = 1.4826 * nth(sorted.data(), count, middle);
        const double scale = 1 / (limit.EDGE_OUTLIER * std::max(error, limit.MIN_EDGE_OUTLIER / 3));
        for (int i = 0; i < count; ++i) {
            const double part = good[i] ? std::min(size[i] * scale, 1.0) : 1.0;
            weight[i] = (1 - part * part) * (1 - part * part);
        }
        return error;
    }
};

// Sets the Jacobian, offsets and which are edges, with parameters theta; returns the number of edges.
template <typename Model>
int measure(Fit& fit, const Image& grey, const Lens& lens, Model& model, const double* theta, const EdgePoints& points,
            const double* scale, double reach, const Thresholds& limit) {
    const int count = points.x.size();
    model.set(theta);
    int visible = 0;
    for (int i = 0; i < count; ++i) {
        const SeenEdge seen = model.edge(points.x[i], points.y[i], points.right[i], points.down[i]);
        for (int k = 0; k < fit.free; ++k) fit.jacobian[k * count + i] = seen.row[k] * scale[k];

        float px[kRead], py[kRead], read[kRead], sum = 0;
        for (int k = 0; k < kRead; ++k) {
            const double at = reach * (k - kAcross / 2) / (kAcross / 2);
            px[k] = seen.u + seen.du * at, py[k] = seen.v + seen.dv * at;
        }
        lens.to_real(px, py, kRead);
        grey.read(px, py, kRead, read);
        for (int k = 0; k < kAcross; ++k) sum += read[k];
        const float black = (read[0] + read[1] + read[2]) / kEnds;
        const float white = (read[kAcross - 3] + read[kAcross - 2] + read[kAcross - 1]) / kEnds;
        const float step = white - black, mean = sum / kAcross;
        const float low = grey.grey_of(black), high = grey.grey_of(white);
        bool good = high - low > limit.MIN_LOCAL_CONTRAST * (high + low + limit.DARK_GREY)
                    && high - low > limit.MIN_LOCAL_STEP;
        for (int k = 0; k < kAcross; k += kAcross - 1)
            good = good && px[k] > 0 && px[k] < grey.width - 1 && py[k] > 0 && py[k] < grey.height - 1;
        good = good && mean >= black && mean <= white;  // else the step lies beyond the samples
        fit.good[i] = good;
        fit.offset[i] = good ? (1 - 2 * (mean - black) / step) * reach * kAcross / (kAcross - 1) : 0;
        visible += good;
    }
    return visible;
}

// The evidence of the offsets about the response of the camera: the offsets of a steeper response are fitted together
// with the parameters of the homography.
void weigh_response(const Fit& fit, const Fit& steeper, int count, const double* normal, double error,
                    const Thresholds& limit, ResponseEvidence* out) {
    constexpr int kMost = kMostFree;
    double copy[kMost * kMost], inverse[kMost * kMost], with[kMost] = {}, offset[kMost] = {}, share[kMost];
    const int free = fit.free;
    double square = 0, both = 0;
    std::copy_n(normal, free * free, copy);
    if (!invert(copy, inverse, free)) return;
    for (int i = 0; i < count; ++i) {
        const double weight = steeper.good[i] ? fit.weight[i] : 0;
        const double by = (fit.offset[i] - steeper.offset[i]) / Light::kChange;
        square += weight * by * by, both += weight * by * fit.offset[i];
        for (int k = 0; k < free; ++k) {
            const double row = weight * fit.jacobian[k * count + i];
            with[k] += row * by, offset[k] += row * fit.offset[i];
        }
    }
    multiply(inverse, with, share, free, free, 1);
    for (int k = 0; k < free; ++k) square -= with[k] * share[k], both -= offset[k] * share[k];
    const double least = std::max(error, limit.MIN_EDGE_NOISE), variance = limit.CELL_VARIANCE * least * least;
    out->information = square / variance, out->weighted = both / variance;
}

// The weighted normal equations, with a small ridge; their right side in `change`.
void normal_equations(Fit& fit, int count, double* normal, double* change) {
    const int free = fit.free;
    for (int k = 0; k < free; ++k) {
        const double *row = &fit.jacobian[k * count], *weight = fit.weight.data(), *offset = fit.offset.data();
        double* weighted = fit.weighted.data();
        double sum = 0;
        for (int i = 0; i < count; ++i) weighted[i] = row[i] * weight[i], sum += row[i] * weight[i] * offset[i];
        change[k] = sum;
        for (int l = 0; l <= k; ++l) {
            const double* other = &fit.jacobian[l * count];
            double product = 0;
            for (int i = 0; i < count; ++i) product += weighted[i] * other[i];
            normal[k * free + l] = normal[l * free + k] = product;
        }
    }
    double trace = 0;
    for (int k = 0; k < free; ++k) trace += normal[k * (free + 1)];
    for (int k = 0; k < free; ++k) normal[k * (free + 1)] += 1e-9 * (trace + 1e-9);
}

// Fits a model to the edges, starting from `theta` (free,).
template <typename Model>
EdgeFit fitted(Model model, int free, const double* start, const Image& grey, const Lens& lens, const EdgePoints& points,
               const double* scale, double reach, double first_reach, int steps, const Thresholds& limit,
               const Light* asked = nullptr, ResponseEvidence* evidence = nullptr) {
    const int count = points.x.size();
    EdgeFit result = {};
    double *theta = result.parameters, *covariance = result.covariance;
    std::copy_n(start, kMostFree, theta);
    Fit fit(count, free);
    double normal[kMostFree * kMostFree], copy[kMostFree * kMostFree], change[kMostFree], before[kMostFree] = {};
    double error = 0;
    for (int step = 0; step < steps; ++step) {
        const int visible = measure(fit, grey, lens, model, theta, points, scale, step ? reach : first_reach, limit);
        if (visible < 3 * free) return result;
        const int half = std::min(visible / 2, count - 1);
        for (int i = 0; i < count; ++i) fit.size[i] = std::fabs(fit.offset[i]);
        error = fit.weigh(count, half, limit);
        double furthest = 0;
        for (int again = 0; again < 3; ++again) {
            normal_equations(fit, count, normal, change);
            std::copy_n(normal, free * free, copy);
            if (!solve(copy, change, free, 1)) return result;
            std::fill(fit.weighted.begin(), fit.weighted.end(), 0.0);
            for (int k = 0; k < free; ++k)
                for (int i = 0; i < count; ++i) fit.weighted[i] += fit.jacobian[k * count + i] * change[k];
            furthest = 0;
            for (int i = 0; i < count; ++i) {
                fit.size[i] = std::fabs(fit.offset[i] - fit.weighted[i]);
                furthest = std::max(furthest, std::fabs(fit.weighted[i]));
            }
            error = fit.weigh(count, half, limit);
        }
        std::copy_n(theta, kMostFree, before);
        for (int k = 0; k < free; ++k) theta[k] += change[k] * scale[k];
        if (step && furthest < limit.EDGES_SETTLED) break;
    }
    if (asked) {
        Fit steeper(count, free);
        measure(steeper, grey.lit(asked->steeper), lens, model, before, points, scale, reach, limit);
        weigh_response(fit, steeper, count, normal, error, limit, evidence);
    }
    if (!invert(normal, covariance, free)) return result;
    const double square = std::max(error, 0.03) * std::max(error, 0.03);
    for (int k = 0; k < free; ++k)
        for (int l = 0; l < free; ++l) covariance[k * free + l] *= square * scale[k] * scale[l];
    result.error = error;
    result.agrees.resize(count);
    for (int i = 0; i < count; ++i) {
        result.agrees[i] = fit.good[i] && fit.weight[i] > 0.1;
        result.cost += fit.good[i] ? std::min(fit.size[i] * fit.size[i], 1.0) : 1.0;
    }
    result.seen_enough = true;
    return result;
}

}  // namespace

EdgePoints alvar::edge_points(const std::uint8_t* black, int cells, const std::vector<double>& places) {
    EdgePoints points;
    const auto is_white = [&](int row, int column) {
        return row < 0 || column < 0 || row >= cells || column >= cells || !black[row * cells + column];
    };
    for (int line = 0; line < cells; ++line)
        for (int edge = 0; edge <= cells; ++edge)
            for (int axis = 0; axis < 2; ++axis) {
                const bool before = axis ? is_white(edge - 1, line) : is_white(line, edge - 1);
                const bool after = axis ? is_white(edge, line) : is_white(line, edge);
                if (before == after) continue;
                for (const double place : places) {
                    const double along = line + 0.5 - 0.5 * cells + place, across = edge - 0.5 * cells;
                    points.x.push_back(axis ? along : across), points.y.push_back(axis ? across : along);
                    points.right.push_back(axis ? 0 : after - before);
                    points.down.push_back(axis ? after - before : 0);
                }
            }
    return points;
}

EdgeFit alvar::fit_edges(const Image& grey, const Lens& lens, const double* h, const EdgePoints& points,
                         const double* scale, double reach, double first_reach, int steps, const Thresholds& limit,
                         const Light* asked, ResponseEvidence* evidence) {
    const double start[kMostFree] = {};
    return fitted(Flat(h), 8, start, grey, lens, points, scale, reach, first_reach, steps, limit, asked, evidence);
}

EdgeFit alvar::fit_curved(const Image& grey, const Lens& lens, int cells, const double* theta, int parameters, int free,
                          const EdgePoints& points, const double* scale, double reach, double first_reach, int steps,
                          const Thresholds& limit) {
    double start[kMostFree] = {};
    std::copy_n(theta, parameters, start);
    return fitted(Curved(lens, cells, parameters), free, start, grey, lens, points, scale, reach, first_reach, steps,
                  limit);
}
