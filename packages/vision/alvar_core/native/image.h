// Grey images, and the lens of a camera, as detection/pyramid.py and camera.py have them.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace alvar {

#define ALVAR_INLINE inline __attribute__((always_inline))

ALVAR_INLINE float within(float value, float low, float high) {  // NaN becomes low
    value = value > low ? value : low;
    return value < high ? value : high;
}

// Greys are interpolated in fixed point that fits in 31 bits, for a block of places at once.
constexpr int kPartBits = 10;
constexpr std::int32_t kParts = 1 << kPartBits;
constexpr int kBlock = 72;

constexpr int kGreys = 256;

// light.Light: how much light each grey stands for, with the exponent of the camera's response and with a larger one
struct Light {
    static constexpr double kChange = 0.1;  // the logarithm of the ratio of both exponents
    static constexpr int kSteps = 1 << 16;
    double gamma;
    float of_grey[kGreys], steeper[kGreys];
    std::uint8_t grey_at[kSteps];  // the grey that stands for the light of each step, from no light to that of white

    explicit Light(double exponent) : gamma(exponent) {
        for (int grey = 0; grey < kGreys; ++grey) {
            const double share = grey / (kGreys - 1.0);
            of_grey[grey] = (kGreys - 1) * std::pow(share, gamma);
            steeper[grey] = (kGreys - 1) * std::pow(share, gamma * std::exp(kChange));
        }
        for (int grey = 0, step = 0; grey < kGreys; ++grey) {
            const int next = (kSteps - 1) * std::pow(std::min((grey + 0.5) / (kGreys - 1), 1.0), gamma);
            while (step <= next) grey_at[step++] = grey;
        }
    }

    // Light of an Image; null if greys are light
    const float* table() const { return gamma == 1 ? nullptr : of_grey; }
};

// Rows of `width` greys, `stride` bytes from one to the next. `light` (kGreys,), rising, is how much light each grey
// stands for; without it, greys are light.
struct Image {
    const std::uint8_t* greys;
    std::int64_t stride;
    int width, height;
    const float* light = nullptr;

    // The same image, read as light
    Image lit(const float* by) const { return {greys, stride, width, height, by}; }

    // The grey that stands for this much light, between whole ones
    float grey_of(float value) const {
        if (!light) return value;
        int above = 0;  // as std::upper_bound, without branches
        for (int step = kGreys / 2; step; step /= 2) above += light[above + step - 1] <= value ? step : 0;
        if (above == 0) return 0;
        return above - 1 + (value - light[above - 1]) / (light[above] - light[above - 1]);
    }

    // The greys, or their light, at `count` places, at most kBlock: between pixels, interpolated; beyond the image,
    // those of its edge.
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
            column[i] = column[i] < last_column ? column[i] : last_column;
            row[i] = row[i] < last_row ? row[i] : last_row;
        }
        // Pixels are fetched one by one, so that the arithmetic is done on eight places at once
        const auto pixel = [&](int i) { return greys + (row[i] >> kPartBits) * stride + (column[i] >> kPartBits); };
        if (light) {
            float left_above[kBlock], right_above[kBlock], left_below[kBlock], right_below[kBlock];
            for (int i = 0; i < count; ++i) {
                const std::uint8_t* p = pixel(i);
                left_above[i] = light[p[0]], right_above[i] = light[p[1]];
                left_below[i] = light[p[stride]], right_below[i] = light[p[stride + 1]];
            }
            for (int i = 0; i < count; ++i) {
                const float more = (column[i] & (kParts - 1)) * (1.0f / kParts);
                const float below = (row[i] & (kParts - 1)) * (1.0f / kParts);
                const float upper = left_above[i] + (right_above[i] - left_above[i]) * more;
                const float lower = left_below[i] + (right_below[i] - left_below[i]) * more;
                out[i] = upper + (lower - upper) * below;
            }
            return;
        }
        std::int32_t pair_above[kBlock], pair_below[kBlock];  // the right one in the higher byte
        for (int i = 0; i < count; ++i) {
            const std::uint8_t* p = pixel(i);
            pair_above[i] = p[0] | p[1] << 8, pair_below[i] = p[stride] | p[stride + 1] << 8;
        }
        for (int i = 0; i < count; ++i) {
            const int more = column[i] & (kParts - 1), below = row[i] & (kParts - 1);
            const int upper = (pair_above[i] & 255) * (kParts - more) + (pair_above[i] >> 8) * more;
            const int lower = (pair_below[i] & 255) * (kParts - more) + (pair_below[i] >> 8) * more;
            out[i] = static_cast<float>(upper * (kParts - below) + lower * below) * (1.0f / (kParts * kParts));
        }
    }
};

// The lens of a Camera (camera.py): plumb_bob or rational distortion k1 k2 p1 p2 k3 k4 k5 k6; or that of a FisheyeCamera
// (camera.FisheyeCamera): k1 k2 k3 k4.
struct Lens {
    double fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6;
    bool fisheye;

    bool distorted() const {
        return fisheye || k1 != 0 || k2 != 0 || p1 != 0 || p2 != 0 || k3 != 0 || k4 != 0 || k5 != 0 || k6 != 0;
    }

    // Turns `count` ideal places into real ones.
    ALVAR_INLINE void to_real(float* x, float* y, int count) const {
        if (!distorted()) return;
        const float per_fx = 1 / fx, per_fy = 1 / fy, wide = fx, high = fy, left = cx, top = cy, p = p1, q = p2;
        const float a = k1, b = k2, c = k3, d = k4, e = k5, f = k6;
        if (fisheye) {
            for (int i = 0; i < count; ++i) {
                const float u = (x[i] - left) * per_fx, v = (y[i] - top) * per_fy, radius = std::sqrt(u * u + v * v);
                const float theta = std::atan(radius), t2 = theta * theta;
                const float drawn = theta * (1 + t2 * (a + t2 * (b + t2 * (c + t2 * d))));
                const float scale = radius > 1e-9f ? drawn / radius : 1;
                x[i] = u * scale * wide + left, y[i] = v * scale * high + top;
            }
            return;
        }
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
        if (fisheye) {
            const double radius = std::sqrt(r2), scale = radius > 1e-9 ? drawn_at(std::atan(radius)) / radius : 1;
            *real_x = u * scale * fx + cx, *real_y = v * scale * fy + cy;
            return;
        }
        const double scale = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)));
        *real_x = (u * scale + 2 * p1 * uv + p2 * (r2 + 2 * uu)) * fx + cx;
        *real_y = (v * scale + p1 * (r2 + 2 * vv) + 2 * p2 * uv) * fy + cy;
    }

    // Turns a real place into the ideal one, by repeated correction.
    void to_ideal(double x, double y, double* ideal_x, double* ideal_y) const {
        if (fisheye) {
            const double u = (x - cx) / fx, v = (y - cy) / fy, drawn = std::sqrt(u * u + v * v);
            double theta = drawn;
            for (int again = 0; again < 20; ++again) {  // Newton's method
                const double step = 1e-6, slope = (drawn_at(theta + step) - drawn_at(theta)) / step;
                const double change = (drawn - drawn_at(theta)) / slope;
                theta += change;
                if (std::fabs(change) < 1e-9) break;
            }
            const double scale = drawn > 1e-9 ? std::tan(theta) / drawn : 1;
            *ideal_x = u * scale * fx + cx, *ideal_y = v * scale * fy + cy;
            return;
        }
        *ideal_x = x, *ideal_y = y;
        for (int again = 0; again < 20; ++again) {
            double real_x, real_y;
            to_real(*ideal_x, *ideal_y, &real_x, &real_y);
            *ideal_x += x - real_x, *ideal_y += y - real_y;
            if (std::fabs(x - real_x) + std::fabs(y - real_y) < 1e-3) break;
        }
    }

private:
    // The radius, in focal lengths, at which a fisheye lens shows a ray at an angle [rad] to the optical axis
    double drawn_at(double theta) const {
        const double t2 = theta * theta;
        return theta * (1 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4))));
    }
};

// A level of a Pyramid (pyramid.py): a row of its table
struct Level {
    float scale, x_offset, y_offset, left, top, right, bottom;
};

// An image at three sizes in one: `atlas`
struct Pyramid {
    Image atlas;
    const Level* levels;
};

}  // namespace alvar
