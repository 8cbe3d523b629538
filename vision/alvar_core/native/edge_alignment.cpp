// EdgeAligner.fit of detection/edge_alignment.py with the model Plane. Names and formulas are those of that file.
#include <cstring>
#include <limits>
#include <vector>

#include "algebra.h"
#include "edge_fit.h"
#include "image.h"

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
    double weigh(int count, int middle, const EdgeLimits& limit) {
        for (int i = 0; i < count; ++i) sorted[i] = good[i] ? size[i] : std::numeric_limits<double>::infinity();
        const double error = 1.4826 * nth(sorted.data(), count, middle);
        const double scale = 1 / (limit.outlier * std::max(error, limit.min_outlier / 3));
        for (int i = 0; i < count; ++i) {
            const double part = good[i] ? std::min(size[i] * scale, 1.0) : 1.0;
            weight[i] = (1 - part * part) * (1 - part * part);
        }
        return error;
    }
};

// Sets the Jacobian, offsets and which are edges, with parameters theta; returns the number of edges.
int look(Fit& fit, const Image& grey, const Lens& lens, const double* start, const double* theta,
                    const EdgePoints& points, const double* scale, double reach, const EdgeLimits& limit) {
    double h[9];
    const double small[9] = {1 + theta[1], theta[2],  theta[0], theta[4], 1 + theta[5],
                             theta[3],     -theta[6], -theta[7], 1};
    multiply(start, small, h, 3, 3, 3);
    int visible = 0;
    for (int i = 0; i < points.count; ++i) {
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
        for (int k = 0; k < kFree; ++k) fit.jacobian[k * points.count + i] = row[k] * scale[k];

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
        bool good = step > limit.min_contrast * (white + black + limit.dark_grey) && step > limit.min_step;
        for (int k = 0; k < kAcross; k += kAcross - 1)
            good = good && px[k] > 0 && px[k] < grey.width - 1 && py[k] > 0 && py[k] < grey.height - 1;
        good = good && mean >= black && mean <= white;  // else the step lies beyond what is read
        fit.good[i] = good;
        fit.offset[i] = good ? (1 - 2 * (mean - black) / step) * reach * kAcross / (kAcross - 1) : 0;
        visible += good;
    }
    return visible;
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

bool alvar::fit_edges(const Image& grey, const Lens& lens, const double* h, const EdgePoints& points,
                      const double* scale, double reach, double first_reach, int steps, const EdgeLimits& limit,
                      double* theta, double* covariance, double* numbers, std::uint8_t* agrees) {
    const int count = points.count;
    Fit fit(count);
    double normal[kFree * kFree], copy[kFree * kFree], change[kFree], error = 0;
    std::fill(theta, theta + kFree, 0.0);
    for (int step = 0; step < steps; ++step) {
        const int visible = look(fit, grey, lens, h, theta, points, scale, step ? reach : first_reach, limit);
        if (visible < 3 * kFree) return false;
        const int half = std::min(visible / 2, count - 1);
        for (int i = 0; i < count; ++i) fit.size[i] = std::fabs(fit.offset[i]);
        error = fit.weigh(count, half, limit);
        double furthest = 0;
        for (int again = 0; again < 3; ++again) {
            normal_equations(fit, count, normal, change);
            std::memcpy(copy, normal, sizeof copy);
            if (!solve(copy, change, kFree, 1)) return false;
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
        for (int k = 0; k < kFree; ++k) theta[k] += change[k] * scale[k];
        if (step && furthest < limit.settled) break;
    }
    if (!invert(normal, covariance, kFree)) return false;
    const double square = std::max(error, 0.03) * std::max(error, 0.03);
    for (int k = 0; k < kFree; ++k)
        for (int l = 0; l < kFree; ++l) covariance[k * kFree + l] *= square * scale[k] * scale[l];
    numbers[0] = error, numbers[1] = 0;
    for (int i = 0; i < count; ++i) {
        agrees[i] = fit.good[i] && fit.weight[i] > 0.1;
        numbers[1] += fit.good[i] ? std::min(fit.size[i] * fit.size[i], 1.0) : 1.0;
    }
    return true;
}

// Returns whether enough edges are seen; `middle` (2, count), `outward` (2, count).
extern "C" int alvar_fit_edges(const std::uint8_t* greys, std::int64_t stride, int width, int height,
                               const double* lens_numbers, const double* h, int count, const double* middle,
                               const double* outward, const double* scale, double reach, double first_reach, int steps,
                               const double* limits, double* theta, double* covariance, double* numbers,
                               std::uint8_t* agrees) {
    EdgeLimits limit;
    std::memcpy(&limit, limits, sizeof limit);
    return fit_edges({greys, stride, width, height}, Lens(lens_numbers), h,
                     {count, middle, middle + count, outward, outward + count}, scale, reach, first_reach, steps, limit,
                     theta, covariance, numbers, agrees);
}
