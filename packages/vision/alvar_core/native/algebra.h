// Small matrices, row by row, and medians.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>

namespace alvar {

// Solves a x = b by Gaussian elimination: a (n, n) is destroyed, b (n, columns) becomes x. False if a is singular.
inline bool solve(double* a, double* b, int n, int columns) {
    for (int k = 0; k < n; ++k) {
        int pivot = k;
        for (int i = k + 1; i < n; ++i)
            if (std::fabs(a[i * n + k]) > std::fabs(a[pivot * n + k])) pivot = i;
        if (!(std::fabs(a[pivot * n + k]) > 0)) return false;
        if (pivot != k) {
            std::swap_ranges(a + k * n, a + (k + 1) * n, a + pivot * n);
            std::swap_ranges(b + k * columns, b + (k + 1) * columns, b + pivot * columns);
        }
        const double inverse = 1 / a[k * n + k];
        for (int i = k + 1; i < n; ++i) {
            const double share = a[i * n + k] * inverse;
            if (share == 0) continue;
            for (int j = k + 1; j < n; ++j) a[i * n + j] -= share * a[k * n + j];
            for (int j = 0; j < columns; ++j) b[i * columns + j] -= share * b[k * columns + j];
        }
    }
    for (int k = n - 1; k >= 0; --k) {
        for (int i = k + 1; i < n; ++i)
            for (int j = 0; j < columns; ++j) b[k * columns + j] -= a[k * n + i] * b[i * columns + j];
        for (int j = 0; j < columns; ++j) b[k * columns + j] /= a[k * n + k];
    }
    return true;
}

// Inverts a (n, n), which is destroyed, into `out`. False if a is singular.
inline bool invert(double* a, double* out, int n) {
    for (int i = 0; i < n * n; ++i) out[i] = i % (n + 1) == 0;
    return solve(a, out, n, n);
}

// out (n, m) = a (n, k) b (k, m)
inline void multiply(const double* a, const double* b, double* out, int n, int k, int m) {
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < m; ++j) {
            double sum = 0;
            for (int l = 0; l < k; ++l) sum += a[i * k + l] * b[l * m + j];
            out[i * m + j] = sum;
        }
}

// Changes a homography by d (8): as homography.small, applied before it. The result has 1 at its end.
inline void change(double* h, const double* d) {
    const double small[9] = {1 + d[1], d[2], d[0], d[4], 1 + d[5], d[3], -d[6], -d[7], 1};
    double out[9];
    multiply(h, small, out, 3, 3, 3);
    for (int i = 0; i < 9; ++i) h[i] = out[i] / out[8];
}

// homography.from_square: from the square [-half, half]^2 to a quad (4, 2)
inline void from_square(const double* q, double half, double* m) {
    const double ax = q[2] - q[4], ay = q[3] - q[5], bx = q[6] - q[4], by = q[7] - q[5];
    const double cx = q[0] - q[2] + q[4] - q[6], cy = q[1] - q[3] + q[5] - q[7];
    double den = ax * by - bx * ay;
    if (std::fabs(den) < 1e-12) den = 1e-12;
    const double g = (cx * by - bx * cy) / den, e = (ax * cy - cx * ay) / den;
    const double first[9] = {q[2] - q[0] + g * q[2], q[6] - q[0] + e * q[6], q[0],
                             q[3] - q[1] + g * q[3], q[7] - q[1] + e * q[7], q[1], g, e, 1};
    const double end = 1 + 0.5 * (g + e);
    for (int i = 0; i < 3; ++i) {
        const double* row = first + 3 * i;
        m[3 * i] = 0.5 / half * row[0] / end, m[3 * i + 1] = 0.5 / half * row[1] / end;
        m[3 * i + 2] = (row[2] + 0.5 * (row[0] + row[1])) / end;
    }
}

// homography.area of a quad (4, 2): positive if its corners are clockwise in the image
inline double area(const double* q) {
    return 0.5 * ((q[0] - q[4]) * (q[3] - q[7]) - (q[1] - q[5]) * (q[2] - q[6]));
}

const double kSquare[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};  // the corners, y down

// The corners (4, 2) of the square [-half, half]^2 at a homography
inline void corners_at(const double* h, double half, double* corners) {
    for (int k = 0; k < 4; ++k) {
        const double x = kSquare[k][0] * half, y = kSquare[k][1] * half, w = h[6] * x + h[7] * y + h[8];
        corners[2 * k] = (h[0] * x + h[1] * y + h[2]) / w, corners[2 * k + 1] = (h[3] * x + h[4] * y + h[5]) / w;
    }
}

// alignment.covariance: xx, yy, xy [cells^2] of a blur, given as variance [px^2]
inline void blur_in_cells(const double* h, double blur, double* out) {
    const double cx = h[2] / h[8], cy = h[5] / h[8];
    const double a = (h[0] - cx * h[6]) / h[8], b = (h[1] - cx * h[7]) / h[8];
    const double c = (h[3] - cy * h[6]) / h[8], d = (h[4] - cy * h[7]) / h[8];
    const double xx = a * a + c * c, yy = b * b + d * d, xy = a * b + c * d;
    const double scale = blur / (xx * yy - xy * xy);
    out[0] = yy * scale, out[1] = xx * scale, out[2] = -xy * scale;
}

// The element with `middle` smaller ones; the order of the values is lost.
template <typename Number>
Number nth(Number* values, int count, int middle) {
    std::nth_element(values, values + middle, values + count);
    return values[middle];
}

// The same for numbers that are not negative, whose order stays: bit by bit, since such numbers are ordered as their
// bits are.
inline float nth_positive(const float* values, int count, int middle) {
    std::int32_t bits = 0;
    for (std::int32_t bit = 1 << 30; bit; bit >>= 1) {
        const std::int32_t tried = bits | bit;
        int smaller = 0;
        for (int i = 0; i < count; ++i) {
            std::int32_t own;
            std::memcpy(&own, values + i, sizeof own);
            smaller += own < tried;
        }
        if (smaller <= middle) bits = tried;
    }
    float found;
    std::memcpy(&found, &bits, sizeof found);
    return found;
}

}  // namespace alvar
