// Aligner.run of detection/alignment.py, one marker after the other. Names and formulas are those of that file.
#include <cstring>
#include <vector>

#include "algebra.h"
#include "image.h"
#include "steps.h"

namespace {

using namespace alvar;

constexpr int kParameters = 15, kRows = kParameters + 1, kLane = 8;
typedef float Lanes __attribute__((vector_size(kLane * sizeof(float))));

// The order of alignment.py's LIMITS
struct Limits {
    double first_outlier, outlier, min_start_gain, low_gain, high_gain, max_step, low_blur_step, high_blur_step,
        low_blur, high_blur, min_noise, min_contrast, settled, steps_of_all;
};

// What alignment.py's Grid and Aligner know: `count` samples in each of as many rows.
struct Grid {
    int cells, count;
    const float *line, *weight;  // (count,) [cells], (count, count)
    int padded() const { return (count + kLane - 1) / kLane * kLane; }
};

// exp(x) for -87 < x < 87, to within 2e-7: 2^n times a polynomial (a minimax one of degree 6 on half a power of 2)
ALVAR_INLINE float fast_exp(float x) {
    const float n = std::floor(x * 1.44269504f + 0.5f);
    const float r = x - n * 0.693359375f + n * 2.12194440e-4f;
    float p = 1.9875691500e-4f;
    p = p * r + 1.3981999507e-3f;
    p = p * r + 8.3334519073e-3f;
    p = p * r + 4.1665795894e-2f;
    p = p * r + 1.6666665459e-1f;
    p = p * r + 5.0000001201e-1f;
    p = p * r * r + r + 1;
    union { std::int32_t bits; float value; } power = {(static_cast<std::int32_t>(n) + 127) << 23};
    return p * power.value;
}

struct Marker {
    const Grid& grid;
    int n, wide, edges;                // samples per row, with padding; edges of cells
    std::vector<float> profile[2][3];  // [x, y][value, first, second derivative]: (cells, wide)
    std::vector<float> steps, rows;    // of profiles, of draw
    std::vector<float> shape, by_x, by_y, by_blur, x, y, basis, robust, residual;  // (n, wide)

    explicit Marker(const Grid& g) : grid(g), n(g.count), wide(g.padded()), edges(g.cells + 1) {
        for (auto& axis : profile)
            for (auto& part : axis) part.assign(grid.cells * wide, 0);
        steps.assign(3 * edges * wide, 0);
        rows.assign(3 * grid.cells * wide, 0);
        for (auto* each : {&shape, &by_x, &by_y, &by_blur, &x, &y, &robust}) each->assign(n * wide, 0);
        basis.assign(kRows * wide, 0);
        residual.assign(n * n, 0);
    }

    ALVAR_INLINE void profiles(std::vector<float>* out, float variance, const float* normal_step) {
        const float s = 1 / std::sqrt(variance);
        float *value = &steps[0], *first = &steps[edges * wide], *second = &steps[2 * edges * wide];
        for (int e = 0; e < edges; ++e) {
            const float at = e - grid.cells * 0.5f;
            for (int i = 0; i < n; ++i) {
                const float z = (grid.line[i] - at) * s;
                const float zz = z * z < 30 ? z * z : 30;
                const float u = z * (normal_step[0] + zz * (normal_step[1] + zz * normal_step[2]));
                const float density = fast_exp(-0.5f * zz) * s * 0.3989423f;
                value[e * wide + i] = 0.5f - 1 / (fast_exp(2 * within(u, -20, 20)) + 1);  // half of tanh
                first[e * wide + i] = density;
                second[e * wide + i] = density * z * -s;
            }
        }
        for (int part = 0; part < 3; ++part)
            for (int i = 0; i < grid.cells * wide; ++i)
                out[part][i] = steps[part * edges * wide + i] - steps[part * edges * wide + wide + i];
    }

    // The drawing of black cells (cells, cells) with a blur of covariance xx, yy, xy [cells^2]
    ALVAR_INLINE void draw(const std::uint8_t* black, float xx, float yy, float xy, const float* normal_step) {
        const int cells = grid.cells;
        profiles(profile[0], xx, normal_step);
        profiles(profile[1], yy, normal_step);
        for (int part = 0; part < 3; ++part)
            for (int r = 0; r < cells; ++r) {
                float* row = &rows[(part * cells + r) * wide];
                std::memset(row, 0, wide * sizeof(float));
                for (int c = 0; c < cells; ++c)
                    if (black[r * cells + c])
                        for (int i = 0; i < wide; ++i) row[i] += profile[0][part][c * wide + i];
            }
        const float *plain = &rows[0], *first = &rows[cells * wide], *second = &rows[2 * cells * wide];
        for (int j = 0; j < n; ++j) {
            float *t = &shape[j * wide], *tx = &by_x[j * wide], *ty = &by_y[j * wide], *tb = &by_blur[j * wide];
            std::memset(t, 0, wide * sizeof(float));
            std::memset(tx, 0, wide * sizeof(float));
            std::memset(ty, 0, wide * sizeof(float));
            std::memset(tb, 0, wide * sizeof(float));
            for (int r = 0; r < cells; ++r) {
                const float a = profile[1][0][r * wide + j], b = profile[1][1][r * wide + j];
                const float c = profile[1][2][r * wide + j];
                if (std::fabs(a) + std::fabs(b) + std::fabs(c) < 1e-7f) continue;  // too far away
                const float *p = plain + r * wide, *q = first + r * wide, *s = second + r * wide;
                for (int i = 0; i < wide; ++i) {
                    const float cross = b * xy * q[i];
                    t[i] -= a * p[i] + cross;
                    tx[i] -= a * q[i];
                    ty[i] -= b * p[i];
                    tb[i] -= 0.5f * xx * a * s[i] + 0.5f * yy * c * p[i] + cross;
                }
            }
            for (int i = 0; i < n; ++i) t[i] += 1;
        }
    }
};

struct State {  // the fields of an Alignment of one marker
    double *h, *blur;
    float *values, *templates, *model, *gain, *dark, *weights;
    double *contrast, *noise, *normal, *moved;
};

struct Level {  // a row of Pyramid's table
    float scale, x_offset, y_offset, left, top, right, bottom;
};

void align(Marker& m, const Image& atlas, const Level& box, double level_scale, const Lens& lens,
                      const std::uint8_t* black, const float* normal_step, const Limits& limit, int steps,
                      unsigned redraw, State s) {
    const Grid& grid = m.grid;
    const int n = m.n, wide = m.wide;
    const float half = grid.cells * 0.5f, per_half = 1 / half;
    const double reach_of[8] = {1, half, half, 1, half, half, half * half, half * half};
    for (int step = 0; step < steps; ++step) {
        if (step >= limit.steps_of_all && !(*s.moved > limit.settled)) break;
        double* h = s.h;
        if (step == 0 || (redraw >> step & 1)) {
            const double cx = h[2] / h[8], cy = h[5] / h[8];
            const double a = (h[0] - cx * h[6]) / h[8], b = (h[1] - cx * h[7]) / h[8];
            const double c = (h[3] - cy * h[6]) / h[8], d = (h[4] - cy * h[7]) / h[8];
            const double xx = a * a + c * c, yy = b * b + d * d, xy = a * b + c * d;
            const double scale = *s.blur * level_scale / (xx * yy - xy * xy);
            m.draw(black, yy * scale, xx * scale, -xy * scale, normal_step);
            for (int j = 0; j < n; ++j) std::memcpy(s.templates + j * n, &m.shape[j * wide], n * sizeof(float));
        }
        // places and values
        const float f[9] = {float(h[0]), float(h[1]), float(h[2]), float(h[3]), float(h[4]),
                            float(h[5]), float(h[6]), float(h[7]), float(h[8])};
        for (int j = 0; j < n; ++j) {
            const float v = grid.line[j], px = f[1] * v + f[2], py = f[4] * v + f[5], pw = f[7] * v + f[8];
            float *x = &m.x[j * wide], *y = &m.y[j * wide];
            for (int i = 0; i < n; ++i) {
                const float u = grid.line[i], w = 1 / (f[6] * u + pw);
                x[i] = (f[0] * u + px) * w;
                y[i] = (f[3] * u + py) * w;
            }
            lens.to_real(x, y, n);
            for (int i = 0; i < n; ++i) {
                x[i] = x[i] * box.scale + box.x_offset;
                y[i] = y[i] * box.scale + box.y_offset;
            }
            for (int i = 0; i < n; i += kBlock)
                atlas.read(x + i, y + i, std::min(kBlock, n - i), box.left, box.top, box.right, box.bottom,
                           s.values + j * n + i);
        }
        if (step == 0) {  // the first weights and gain
            double sum = 0, of_value = 0, of_shape = 0, both = 0, square = 0;
            for (int i = 0; i < n * n; ++i) {
                const double w = grid.weight[i];
                sum += w, of_value += w * s.values[i], of_shape += w * s.templates[i];
                both += w * s.values[i] * s.templates[i], square += w * s.templates[i] * s.templates[i];
            }
            of_value /= sum, of_shape /= sum;
            double gain = (both / sum - of_value * of_shape) / (square / sum - of_shape * of_shape + 1e-6);
            gain = gain > limit.min_start_gain ? gain : limit.min_start_gain;
            std::fill(s.gain, s.gain + n * n, static_cast<float>(gain));
            std::memcpy(s.weights, grid.weight, n * n * sizeof(float));
        }
        // normal equations: the basis of one row of samples at a time
        Lanes product[kRows / 4 * (kRows / 4 + 1) / 2][16] = {};
        for (int j = 0; j < n; ++j) {
            const float v = grid.line[j], v_half = v * per_half;
            const float *t = &m.shape[j * wide], *tx = &m.by_x[j * wide], *ty = &m.by_y[j * wide];
            const float *gain = s.gain + j * n, *values = s.values + j * n, *weights = s.weights + j * n;
            float* b = &m.basis[0];
            for (int i = 0; i < n; ++i) {
                const float u = grid.line[i], root = std::sqrt(weights[i]);
                const float bx = tx[i] * gain[i] * root, by = ty[i] * gain[i] * root, both = bx * u + by * v;
                b[i] = bx, b[wide + i] = bx * u, b[2 * wide + i] = bx * v;
                b[3 * wide + i] = by, b[4 * wide + i] = by * u, b[5 * wide + i] = by * v;
                b[6 * wide + i] = both * u, b[7 * wide + i] = both * v;
                const float tr = t[i] * root;
                b[8 * wide + i] = tr, b[9 * wide + i] = tr * u * per_half, b[10 * wide + i] = tr * v_half;
                b[11 * wide + i] = root, b[12 * wide + i] = root * u * per_half, b[13 * wide + i] = root * v_half;
                b[14 * wide + i] = m.by_blur[j * wide + i] * root, b[15 * wide + i] = values[i] * root;
            }
            int block = 0;
            for (int p = 0; p < kRows; p += 4)
                for (int q = p; q < kRows; q += 4, ++block) {
                    Lanes sums[16];
                    for (int k = 0; k < 16; ++k) sums[k] = product[block][k];
                    for (int i = 0; i < wide; i += kLane) {
                        Lanes left[4], right[4];
                        for (int k = 0; k < 4; ++k) {
                            std::memcpy(&left[k], b + (p + k) * wide + i, sizeof(Lanes));
                            std::memcpy(&right[k], b + (q + k) * wide + i, sizeof(Lanes));
                        }
                        for (int k = 0; k < 16; ++k) sums[k] += left[k / 4] * right[k % 4];
                    }
                    for (int k = 0; k < 16; ++k) product[block][k] = sums[k];
                }
        }
        double ridged[kParameters * kParameters], theta[kParameters];
        int block = 0;
        for (int p = 0; p < kRows; p += 4)
            for (int q = p; q < kRows; q += 4, ++block)
                for (int k = 0; k < 16; ++k) {
                    double sum = 0;
                    for (int lane = 0; lane < kLane; ++lane) sum += product[block][k][lane];
                    const int row = p + k / 4, column = q + k % 4;
                    if (row == kParameters) continue;
                    if (column == kParameters) theta[row] = sum;
                    else s.normal[row * kParameters + column] = s.normal[column * kParameters + row] = sum;
                }
        std::memcpy(ridged, s.normal, sizeof ridged);
        for (int k = 0; k < kParameters; ++k) {
            ridged[k * kRows] *= 1 + 1e-6;
            ridged[k * kRows] += 1e-9;
        }
        solve(ridged, theta, kParameters, 1);
        // model, residual
        float c[kParameters];
        for (int k = 0; k < kParameters; ++k) c[k] = theta[k];
        for (int j = 0; j < n; ++j) {
            const float v = grid.line[j];
            const float *t = &m.shape[j * wide], *tx = &m.by_x[j * wide], *ty = &m.by_y[j * wide];
            const float* tb = &m.by_blur[j * wide];
            const float *gain = s.gain + j * n, *values = s.values + j * n;
            float *model = s.model + j * n, *residual = &m.residual[j * n];
            for (int i = 0; i < n; ++i) {
                const float u = grid.line[i], along = c[6] * u + c[7] * v;
                const float shift = tx[i] * gain[i] * (c[0] + c[1] * u + c[2] * v + along * u)
                                    + ty[i] * gain[i] * (c[3] + c[4] * u + c[5] * v + along * v);
                const float light = c[8] + (c[9] * u + c[10] * v) * per_half;
                const float dark = c[11] + (c[12] * u + c[13] * v) * per_half;
                model[i] = shift + t[i] * light + dark + c[14] * tb[i];
                residual[i] = values[i] - model[i];
            }
        }
        const double contrast = theta[8];
        const float grey = contrast > 1 ? contrast : 1;
        for (int j = 0; j < n; ++j) {
            const float v = grid.line[j] * per_half;
            for (int i = 0; i < n; ++i) {
                const float u = grid.line[i] * per_half;
                s.gain[j * n + i] = within(c[8] + c[9] * u + c[10] * v, limit.low_gain * grey, limit.high_gain * grey);
                s.dark[j * n + i] = c[11] + c[12] * u + c[13] * v;
            }
        }
        const double blur = *s.blur * (1 + within(theta[14] / grey, limit.low_blur_step, limit.high_blur_step));
        *s.blur = std::min(std::max(blur, limit.low_blur), limit.high_blur);
        double move[8];
        *s.moved = 0;
        for (int k = 0; k < 8; ++k) {
            move[k] = std::min(std::max(-theta[k], -limit.max_step), limit.max_step);
            *s.moved = std::max(*s.moved, std::fabs(move[k]) * reach_of[k]);
        }
        change(h, move);
        // noise and weights
        int counted = 0, place = 0;
        for (int i = 0; i < n * n; ++i)
            if (grid.weight[i] > 0 && place++ % 3 == 0) m.robust[counted++] = std::fabs(m.residual[i]);
        *s.noise = 1.4826 * nth(m.robust.data(), counted, counted / 2);
        const double least = limit.min_noise * std::max(contrast, limit.min_contrast);
        const float per_limit = 1 / ((step ? limit.outlier : limit.first_outlier) * std::max(*s.noise, least));
        for (int i = 0; i < n * n; ++i) {
            float part = m.residual[i] * per_limit;
            part = part * part < 1 ? 1 - part * part : 0;
            s.weights[i] = part * part * grid.weight[i];
        }
        *s.contrast = contrast;
    }
}

}  // namespace

extern "C" void alvar_align(int markers, const std::uint8_t* atlas, std::int64_t stride, int width, int height,
                            const float* table, const double* lens_numbers, int cells, int count, const float* line,
                            const float* weight, const float* normal_step, const double* limits, int steps,
                            unsigned redraw, const std::uint8_t* black, const std::int64_t* level, double* h,
                            double* blur, float* samples, double* numbers, double* normal) {
    const Grid grid = {cells, count, line, weight};
    Marker marker(grid);
    const Lens lens(lens_numbers);
    const Image image = {atlas, stride, width, height};
    Limits limit;
    std::memcpy(&limit, limits, sizeof limit);
    const std::int64_t each = std::int64_t(count) * count, all = each * markers;
    for (int m = 0; m < markers; ++m) {
        Level box;
        std::memcpy(&box, table + 7 * level[m], sizeof box);
        float* first = samples + m * each;
        align(marker, image, box, std::pow(4.0, level[m]), lens, black + m * cells * cells, normal_step, limit, steps,
              redraw,
              {h + 9 * m, blur + m, first, first + all, first + 2 * all, first + 3 * all, first + 4 * all,
               first + 5 * all, numbers + m, numbers + markers + m, normal + m * kParameters * kParameters,
               numbers + 2 * markers + m});
    }
}
