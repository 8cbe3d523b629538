// Grey images, and the lens of a camera, as detection/pyramid.py and camera.py have them.
#pragma once
#include <cmath>
#include <cstdint>

namespace alvar {

#define ALVAR_INLINE inline __attribute__((always_inline))

ALVAR_INLINE float within(float value, float low, float high) {  // NaN becomes low
    value = value > low ? value : low;
    return value < high ? value : high;
}

// Places are read to a part of a pixel, of greys that then fit in 31 bits; blocks of places at once.
constexpr int kPartBits = 10;
constexpr std::int32_t kParts = 1 << kPartBits;
constexpr int kBlock = 72;

// Rows of `width` greys, `stride` bytes from one to the next.
struct Image {
    const std::uint8_t* greys;
    std::int64_t stride;
    int width, height;

    // The greys at `count` places, at most kBlock: between pixels, interpolated; beyond the image, those of its edge.
    ALVAR_INLINE void read(const float* x, const float* y, int count, float* out) const {
        read(x, y, count, 0, 0, static_cast<float>(width - 1), static_cast<float>(height - 1), out);
    }

    // The same within a part of the image.
    ALVAR_INLINE void read(const float* x, const float* y, int count, float left, float top, float right, float bottom,
                           float* out) const {
        std::int32_t column[kBlock], row[kBlock];
        for (int i = 0; i < count; ++i) {
            column[i] = static_cast<std::int32_t>(within(x[i], left, right) * kParts);
            row[i] = static_cast<std::int32_t>(within(y[i], top, bottom) * kParts);
        }
        const int last_column = (width - 1) * kParts - 1, last_row = (height - 1) * kParts - 1;
        for (int i = 0; i < count; ++i) {
            const int across = column[i] < last_column ? column[i] : last_column;
            const int down = row[i] < last_row ? row[i] : last_row;
            const std::uint8_t* p = greys + (down >> kPartBits) * stride + (across >> kPartBits);
            const int more = across & (kParts - 1), below = down & (kParts - 1);
            const int upper = p[0] * (kParts - more) + p[1] * more;
            const int lower = p[stride] * (kParts - more) + p[stride + 1] * more;
            out[i] = static_cast<float>(upper * (kParts - below) + lower * below) * (1.0f / (kParts * kParts));
        }
    }
};

// fx fy cx cy, then k1 k2 p1 p2 k3 k4 k5 k6 of Camera; all but the first four are 0 without distortion.
struct Lens {
    double fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6;
    bool distorted;

    explicit Lens(const double* v)
        : fx(v[0]), fy(v[1]), cx(v[2]), cy(v[3]), k1(v[4]), k2(v[5]), p1(v[6]), p2(v[7]), k3(v[8]), k4(v[9]),
          k5(v[10]), k6(v[11]), distorted(false) {
        for (int i = 4; i < 12; ++i) distorted = distorted || v[i] != 0;
    }

    // Turns `count` ideal places into real ones.
    ALVAR_INLINE void to_real(float* x, float* y, int count) const {
        if (!distorted) return;
        const float per_fx = 1 / fx, per_fy = 1 / fy, wide = fx, high = fy, left = cx, top = cy, p = p1, q = p2;
        const float a = k1, b = k2, c = k3, d = k4, e = k5, f = k6;
        for (int i = 0; i < count; ++i) {
            const float u = (x[i] - left) * per_fx, v = (y[i] - top) * per_fy;
            const float uu = u * u, vv = v * v, uv = u * v, r2 = uu + vv;
            const float scale = (1 + r2 * (a + r2 * (b + r2 * c))) / (1 + r2 * (d + r2 * (e + r2 * f)));
            x[i] = (u * scale + 2 * p * uv + q * (r2 + 2 * uu)) * wide + left;
            y[i] = (v * scale + p * (r2 + 2 * vv) + 2 * q * uv) * high + top;
        }
    }

    // The same for one place in doubles.
    void to_real(double x, double y, double* real_x, double* real_y) const {
        const double u = (x - cx) / fx, v = (y - cy) / fy, uu = u * u, vv = v * v, uv = u * v, r2 = uu + vv;
        const double scale = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)));
        *real_x = (u * scale + 2 * p1 * uv + p2 * (r2 + 2 * uu)) * fx + cx;
        *real_y = (v * scale + p1 * (r2 + 2 * vv) + 2 * p2 * uv) * fy + cy;
    }

    // Turns a real place into the ideal one, which is where the real one of it is: by repeated correction.
    void to_ideal(double x, double y, double* ideal_x, double* ideal_y) const {
        *ideal_x = x, *ideal_y = y;
        for (int again = 0; again < 20; ++again) {
            double real_x, real_y;
            to_real(*ideal_x, *ideal_y, &real_x, &real_y);
            *ideal_x += x - real_x, *ideal_y += y - real_y;
            if (std::fabs(x - real_x) + std::fabs(y - real_y) < 1e-3) break;
        }
    }
};

}  // namespace alvar
