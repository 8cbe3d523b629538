// edge_alignment.edge_points, and edge_alignment.fit_plane: the fit of a flat marker to the edges of its cells
#include <cstring>
#include <limits>

#include "algebra.h"
#include "steps.h"

namespace {

using namespace alvar;

constexpr int kFree = 8, kAcross = 15, kEnds = 3;
constexpr int kRead = 16;  // one more, which is not used: then eight are read at once

struct Fit {
    std::vector<double> jacobian, offset, size, weight, sorted, weighted;  // (8, count), (count,)
    std::vector<char> good;

    explicit Fit(int count)
        : jacobian(count * kFree), offset(count), size(count), weight(count), sorted(count), weighted(count),
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
int measure(Fit& fit, const Image& grey, const Lens& lens, const double* start, const double* theta,
            const EdgePoints& points, const double* scale, double reach, const Thresholds& limit) {
    const int count = points.x.size();
    double h[9];
    const double small[9] = {1 + theta[1], theta[2],  theta[0], theta[4], 1 + theta[5],
                             theta[3],     -theta[6], -theta[7], 1};
    multiply(start, small, h, 3, 3, 3);
    int visible = 0;
    for (int i = 0; i < count; ++i) {
        const double x = points.x[i], y = points.y[i], right = points.right[i], down = points.down[i];
        const double w = h[6] * x + h[7] * y + h[8];
        const double u = (h[0] * x + h[1] * y + h[2]) / w, v = (h[3] * x + h[4] * y + h[5]) / w;
        const double far_out = h[6] * right + h[7] * down, far_along = h[6] * down - h[7] * right;
        const double out_u = h[0] * right + h[1] * down - u * far_out;
        const double out_v = h[3] * right + h[4] * down - v * far_out;
        const double along_u = h[0] * down - h[1] * right - u * far_along;
        const double along_v = h[3] * down - h[4] * right - v * far_along;
        const double side = out_v * along_u - out_u * along_v;
        const double length = std::sqrt(along_u * along_u + along_v * along_v) + 1e-12;
        const double sign = (side > 0) - (side < 0);
        const double du = -along_v * sign / length, dv = along_u * sign / length, dw = -(du * u + dv * v);
        const double by_x = (start[0] * du + start[3] * dv + start[6] * dw) / w;
        const double by_y = (start[1] * du + start[4] * dv + start[7] * dw) / w;
        const double by_w = (start[2] * du + start[5] * dv + start[8] * dw) / w;
        const double row[kFree] = {by_x, by_x * x, by_x * y, by_y, by_y * x, by_y * y, -by_w * x, -by_w * y};
        for (int k = 0; k < kFree; ++k) fit.jacobian[k * count + i] = row[k] * scale[k];

        float px[kRead], py[kRead], read[kRead], sum = 0;
        for (int k = 0; k < kRead; ++k) {
            const double at = reach * (k - kAcross / 2) / (kAcross / 2);
            px[k] = u + du * at, py[k] = v + dv * at;
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
    double copy[kFree * kFree], inverse[kFree * kFree], with[kFree] = {}, offset[kFree] = {}, share[kFree];
    double square = 0, both = 0;
    std::memcpy(copy, normal, sizeof copy);
    if (!invert(copy, inverse, kFree)) return;
    for (int i = 0; i < count; ++i) {
        const double weight = steeper.good[i] ? fit.weight[i] : 0;
        const double by = (fit.offset[i] - steeper.offset[i]) / Light::kChange;
        square += weight * by * by, both += weight * by * fit.offset[i];
        for (int k = 0; k < kFree; ++k) {
            const double row = weight * fit.jacobian[k * count + i];
            with[k] += row * by, offset[k] += row * fit.offset[i];
        }
    }
    multiply(inverse, with, share, kFree, kFree, 1);
    for (int k = 0; k < kFree; ++k) square -= with[k] * share[k], both -= offset[k] * share[k];
    const double least = std::max(error, limit.MIN_EDGE_NOISE), variance = limit.CELL_VARIANCE * least * least;
    out->information = square / variance, out->weighted = both / variance;
}

// The weighted normal equations, with a small ridge; their right side in `change`.
void normal_equations(Fit& fit, int count, double* normal, double* change) {
    for (int k = 0; k < kFree; ++k) {
        const double *row = &fit.jacobian[k * count], *weight = fit.weight.data(), *offset = fit.offset.data();
        double* weighted = fit.weighted.data();
        double sum = 0;
        for (int i = 0; i < count; ++i) weighted[i] = row[i] * weight[i], sum += row[i] * weight[i] * offset[i];
        change[k] = sum;
        for (int l = 0; l <= k; ++l) {
            const double* other = &fit.jacobian[l * count];
            double product = 0;
            for (int i = 0; i < count; ++i) product += weighted[i] * other[i];
            normal[k * kFree + l] = normal[l * kFree + k] = product;
        }
    }
    double trace = 0;
    for (int k = 0; k < kFree; ++k) trace += normal[k * (kFree + 1)];
    for (int k = 0; k < kFree; ++k) normal[k * (kFree + 1)] += 1e-9 * (trace + 1e-9);
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
    const int count = points.x.size();
    EdgeFit result = {};
    double *theta = result.parameters, *covariance = result.covariance;
    Fit fit(count);
    double normal[kFree * kFree], copy[kFree * kFree], change[kFree], before[kFree] = {}, error = 0;
    for (int step = 0; step < steps; ++step) {
        const int visible = measure(fit, grey, lens, h, theta, points, scale, step ? reach : first_reach, limit);
        if (visible < 3 * kFree) return result;
        const int half = std::min(visible / 2, count - 1);
        for (int i = 0; i < count; ++i) fit.size[i] = std::fabs(fit.offset[i]);
        error = fit.weigh(count, half, limit);
        double furthest = 0;
        for (int again = 0; again < 3; ++again) {
            normal_equations(fit, count, normal, change);
            std::memcpy(copy, normal, sizeof copy);
            if (!solve(copy, change, kFree, 1)) return result;
            std::fill(fit.weighted.begin(), fit.weighted.end(), 0.0);
            for (int k = 0; k < kFree; ++k)
                for (int i = 0; i < count; ++i) fit.weighted[i] += fit.jacobian[k * count + i] * change[k];
            furthest = 0;
            for (int i = 0; i < count; ++i) {
                fit.size[i] = std::fabs(fit.offset[i] - fit.weighted[i]);
                furthest = std::max(furthest, std::fabs(fit.weighted[i]));
            }
            error = fit.weigh(count, half, limit);
        }
        std::copy_n(theta, kFree, before);
        for (int k = 0; k < kFree; ++k) theta[k] += change[k] * scale[k];
        if (step && furthest < limit.EDGES_SETTLED) break;
    }
    if (asked) {
        Fit steeper(count);
        measure(steeper, grey.lit(asked->steeper), lens, h, before, points, scale, reach, limit);
        weigh_response(fit, steeper, count, normal, error, limit, evidence);
    }
    if (!invert(normal, covariance, kFree)) return result;
    const double square = std::max(error, 0.03) * std::max(error, 0.03);
    for (int k = 0; k < kFree; ++k)
        for (int l = 0; l < kFree; ++l) covariance[k * kFree + l] *= square * scale[k] * scale[l];
    result.error = error;
    result.agrees.resize(count);
    for (int i = 0; i < count; ++i) {
        result.agrees[i] = fit.good[i] && fit.weight[i] > 0.1;
        result.cost += fit.good[i] ? std::min(fit.size[i] * fit.size[i], 1.0) : 1.0;
    }
    result.seen_enough = true;
    return result;
}
