// alignment.Aligner: Gauss-Newton steps of one marker after the other
#include <cstring>

#include "algebra.h"
#include "steps.h"

namespace {

using namespace alvar;

constexpr int kRows = kParameters + 1, kLane = 8, kBatch = 4;
typedef float Lanes __attribute__((vector_size(kLane * sizeof(float))));

ALVAR_INLINE Lanes load(const float* from) {
    Lanes lanes;
    std::memcpy(&lanes, from, sizeof lanes);
    return lanes;
}

ALVAR_INLINE void store(const Lanes& lanes, float* to) { std::memcpy(to, &lanes, sizeof lanes); }

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
    const Aligner& grid;
    int n, wide, edges;                // samples per row, with padding; edges of cells
    std::vector<float> profile[2][3];  // [x, y][value, first, second derivative]: (cells, wide)
    std::vector<float> steps, rows;    // of profiles, of draw
    std::vector<float> shape, by_x, by_y, by_blur, x, y, basis, robust;  // (n, wide)
    std::vector<float> values, model, gain, dark, weights, residual;     // (n, wide)
    std::vector<float> line, fixed_weight;  // the grid's, with padding of weight 0
    std::vector<int> noise_samples;         // a third of the places with weight

    explicit Marker(const Aligner& g)
        : grid(g), n(g.count), wide((g.count + kLane - 1) / kLane * kLane), edges(g.cells + 1) {
        for (auto& axis : profile)
            for (auto& part : axis) part.assign(grid.cells * wide, 0);
        steps.assign(3 * edges * wide, 0);
        rows.assign(3 * grid.cells * wide, 0);
        for (auto* each : {&shape, &by_x, &by_y, &by_blur, &x, &y, &robust, &values, &model, &gain, &dark, &weights,
                           &residual, &fixed_weight})
            each->assign(n * wide, 0);
        basis.assign(kRows * kBatch * wide, 0);
        line.assign(wide, 0);
        std::copy_n(grid.line.begin(), n, line.begin());
        for (int j = 0; j < n; ++j) std::copy_n(&grid.weight[j * n], n, &fixed_weight[j * wide]);
        int place = 0;
        for (int i = 0; i < n * wide; ++i)
            if (fixed_weight[i] > 0 && place++ % 3 == 0) noise_samples.push_back(i);
    }

    ALVAR_INLINE void profiles(std::vector<float>* out, float variance) {
        const float s = 1 / std::sqrt(variance);
        float *value = &steps[0], *first = &steps[edges * wide], *second = &steps[2 * edges * wide];
        for (int e = 0; e < edges; ++e) {
            const float at = e - grid.cells * 0.5f;
            for (int i = 0; i < wide; ++i) {
                const float z = (line[i] - at) * s;
                const float zz = z * z < 30 ? z * z : 30;
                const float u = z * (kNormalStep[0] + zz * (kNormalStep[1] + zz * kNormalStep[2]));
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

    // The functions at a row of samples, one every `stride` numbers: derivatives by the parameters, then the values, each
    // times the root of the weight.
    ALVAR_INLINE void set_basis(int j, float* b, int stride) const {
        const float v = line[j], per_half = 2.0f / grid.cells, v_half = v * per_half;
        const float *t = &shape[j * wide], *tx = &by_x[j * wide], *ty = &by_y[j * wide], *tb = &by_blur[j * wide];
        const float *of_gain = &gain[j * wide], *of_values = &values[j * wide], *of_weights = &weights[j * wide];
        const float* across = line.data();
        for (int i = 0; i < wide; i += kLane) {
            Lanes root;
            for (int k = 0; k < kLane; ++k) root[k] = std::sqrt(of_weights[i + k]);
            const Lanes u = load(across + i), g = load(of_gain + i) * root, u_half = u * per_half;
            const Lanes x = load(tx + i) * g, y = load(ty + i) * g, both = x * u + y * v, light = load(t + i) * root;
            const Lanes all[kRows] = {x, x * u, x * v, y, y * u, y * v, both * u, both * v,
                                      light, light * u_half, light * v_half, root, root * u_half, root * v_half,
                                      load(tb + i) * root, load(of_values + i) * root};
            for (int k = 0; k < kRows; ++k) store(all[k], b + k * stride + i);
        }
    }

    // Reads the values at a homography.
    ALVAR_INLINE void sample(const Image& atlas, const Level& box, const Lens& lens, const double* h) {
        const float f[9] = {float(h[0]), float(h[1]), float(h[2]), float(h[3]), float(h[4]),
                            float(h[5]), float(h[6]), float(h[7]), float(h[8])};
        for (int j = 0; j < n; ++j) {
            const float v = line[j], px = f[1] * v + f[2], py = f[4] * v + f[5], pw = f[7] * v + f[8];
            float *across = &x[j * wide], *down = &y[j * wide];
            for (int i = 0; i < wide; ++i) {
                const float u = line[i], w = 1 / (f[6] * u + pw);
                across[i] = (f[0] * u + px) * w;
                down[i] = (f[3] * u + py) * w;
            }
            lens.to_real(across, down, wide);
            for (int i = 0; i < wide; ++i) {
                across[i] = across[i] * box.scale + box.x_offset;
                down[i] = down[i] * box.scale + box.y_offset;
            }
            for (int i = 0; i < wide; i += kBlock)
                atlas.read(across + i, down + i, std::min(kBlock, wide - i), box.left, box.top, box.right, box.bottom,
                           &values[j * wide + i]);
        }
    }

    // The drawing of black cells (cells, cells) with a blur of covariance xx, yy, xy [cells^2]
    ALVAR_INLINE void draw(const std::uint8_t* black, float xx, float yy, float xy) {
        const int cells = grid.cells;
        profiles(profile[0], xx);
        profiles(profile[1], yy);
        for (int part = 0; part < 3; ++part)
            for (int r = 0; r < cells; ++r) {
                float* row = &rows[(part * cells + r) * wide];
                std::memset(row, 0, wide * sizeof(float));
                for (int c = 0; c < cells; ++c)
                    if (black[r * cells + c])
                        for (int i = 0; i < wide; i += kLane)
                            store(load(row + i) + load(&profile[0][part][c * wide + i]), row + i);
            }
        const float *plain = &rows[0], *first = &rows[cells * wide], *second = &rows[2 * cells * wide];
        for (int j = 0; j < n; ++j) {
            float *t = &shape[j * wide], *tx = &by_x[j * wide], *ty = &by_y[j * wide], *tb = &by_blur[j * wide];
            int near[kMostCells], count = 0;
            for (int r = 0; r < cells; ++r) {
                const float a = profile[1][0][r * wide + j], b = profile[1][1][r * wide + j];
                const float c = profile[1][2][r * wide + j];
                if (std::fabs(a) + std::fabs(b) + std::fabs(c) >= 1e-7f) near[count++] = r;  // others are too far away
            }
            for (int i = 0; i < wide; i += kLane) {
                Lanes of_shape = {}, of_x = {}, of_y = {}, of_blur = {};
                for (int k = 0; k < count; ++k) {
                    const int r = near[k];
                    const float a = profile[1][0][r * wide + j], b = profile[1][1][r * wide + j];
                    const float c = profile[1][2][r * wide + j];
                    const Lanes p = load(plain + r * wide + i), q = load(first + r * wide + i);
                    const Lanes cross = b * xy * q;
                    of_shape += a * p + cross, of_x += a * q, of_y += b * p;
                    of_blur += 0.5f * xx * a * load(second + r * wide + i) + 0.5f * yy * c * p + cross;
                }
                store(1.0f - of_shape, t + i), store(-of_x, tx + i), store(-of_y, ty + i), store(-of_blur, tb + i);
            }
        }
    }
};

void align(Marker& m, const Pyramid& pyramid, const Lens& lens, int steps, unsigned redraw, const Thresholds& limit,
           const AlignedMarker& s) {
    const Aligner& grid = m.grid;
    const Level& box = pyramid.levels[s.level];
    const double level_scale = std::pow(4.0, s.level);
    const int n = m.n, wide = m.wide;
    const float* line = m.line.data();
    const float half = grid.cells * 0.5f, per_half = 1 / half;
    const double reach_of[8] = {1, half, half, 1, half, half, half * half, half * half};
    for (int step = 0; step < steps; ++step) {
        if (step >= limit.STEPS_OF_ALL && !(*s.moved > limit.SETTLED)) break;
        double* h = s.h;
        if (step == 0 || (redraw >> step & 1)) {
            double blur[3];
            blur_in_cells(h, *s.blur * level_scale, blur);
            m.draw(s.black, blur[0], blur[1], blur[2]);
        }
        m.sample(pyramid.atlas, box, lens, h);
        if (step == 0) {  // the first weights and gain
            float sum = 0, of_value = 0, of_shape = 0, both = 0, square = 0;
            for (int i = 0; i < n * wide; ++i) {
                const float w = m.fixed_weight[i], value = m.values[i], shape = m.shape[i];
                sum += w, of_value += w * value, of_shape += w * shape;
                both += w * value * shape, square += w * shape * shape;
            }
            of_value /= sum, of_shape /= sum;
            double gain = (both / sum - of_value * of_shape) / (square / sum - of_shape * of_shape + 1e-6);
            gain = gain > limit.MIN_START_GAIN ? gain : limit.MIN_START_GAIN;
            std::fill(m.gain.begin(), m.gain.end(), static_cast<float>(gain));
            m.weights = m.fixed_weight;
        }
        // normal equations: the basis of some rows of samples at a time, of products of 4 by 2 functions
        constexpr int kHigh = 4, kWide = 2;
        Lanes product[kRows / kHigh][kRows / kWide][kHigh * kWide] = {};
        for (int first = 0; first < n; first += kBatch) {
            const int some = std::min(kBatch, n - first), length = some * wide, stride = kBatch * wide;
            for (int j = 0; j < some; ++j) m.set_basis(first + j, &m.basis[j * wide], stride);
            for (int p = 0; p < kRows; p += kHigh)
                for (int q = p; q < kRows; q += kWide) {
                    Lanes* total = product[p / kHigh][q / kWide];
                    Lanes sums[kHigh * kWide] = {};
                    for (int i = 0; i < length; i += kLane) {
                        const float* at = &m.basis[i];
                        const Lanes right[kWide] = {load(at + q * stride), load(at + (q + 1) * stride)};
                        for (int k = 0; k < kHigh; ++k) {
                            const Lanes left = load(at + (p + k) * stride);
                            sums[kWide * k] += left * right[0], sums[kWide * k + 1] += left * right[1];
                        }
                    }
                    for (int k = 0; k < kHigh * kWide; ++k) total[k] += sums[k];
                }
        }
        double ridged[kParameters * kParameters], theta[kParameters];
        for (int row = 0; row < kParameters; ++row)
            for (int column = row / kHigh * kHigh; column < kRows; ++column) {
                const Lanes& sums = product[row / kHigh][column / kWide][row % kHigh * kWide + column % kWide];
                double sum = 0;
                for (int lane = 0; lane < kLane; ++lane) sum += sums[lane];
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
        const double contrast = theta[8];
        const float grey = contrast > 1 ? contrast : 1;
        const Lanes low = Lanes{} + float(limit.GAIN_LIMITS.low * grey);
        const Lanes high = Lanes{} + float(limit.GAIN_LIMITS.high * grey);
        for (int j = 0; j < n; ++j)
            for (int i = j * wide; i < (j + 1) * wide; i += kLane) {
                const float v = line[j];
                const Lanes u = load(line + i - j * wide), along = c[6] * u + c[7] * v, old = load(&m.gain[i]);
                const Lanes shift = load(&m.by_x[i]) * old * (c[0] + c[1] * u + c[2] * v + along * u)
                                    + load(&m.by_y[i]) * old * (c[3] + c[4] * u + c[5] * v + along * v);
                const Lanes light = c[8] + (c[9] * u + c[10] * v) * per_half;
                const Lanes dark = c[11] + (c[12] * u + c[13] * v) * per_half;
                const Lanes model = shift + load(&m.shape[i]) * light + dark + c[14] * load(&m.by_blur[i]);
                const Lanes above = light > low ? light : low;  // NaN becomes low
                store(dark, &m.dark[i]), store(model, &m.model[i]), store(load(&m.values[i]) - model, &m.residual[i]);
                store(above < high ? above : high, &m.gain[i]);
            }
        const Range& change_of_blur = limit.BLUR_STEP_LIMITS;
        const double blur = *s.blur * (1 + within(theta[14] / grey, change_of_blur.low, change_of_blur.high));
        *s.blur = std::min(std::max(blur, limit.BLUR_LIMITS.low), limit.BLUR_LIMITS.high);
        double move[8];
        *s.moved = 0;
        for (int k = 0; k < 8; ++k) {
            move[k] = std::min(std::max(-theta[k], -limit.MAX_STEP), limit.MAX_STEP);
            *s.moved = std::max(*s.moved, std::fabs(move[k]) * reach_of[k]);
        }
        change(h, move);
        // noise and weights
        int counted = 0;
        for (const int place : m.noise_samples) m.robust[counted++] = std::fabs(m.residual[place]);
        *s.noise = 1.4826 * nth_positive(m.robust.data(), counted, counted / 2);
        const double least = limit.MIN_OUTLIER_NOISE * std::max(contrast, limit.MIN_OUTLIER_CONTRAST);
        const float per_limit = 1 / ((step ? limit.OUTLIER : limit.FIRST_OUTLIER) * std::max(*s.noise, least));
        for (int i = 0; i < n * wide; ++i) {
            float part = m.residual[i] * per_limit;
            part = part * part < 1 ? 1 - part * part : 0;
            m.weights[i] = part * part * m.fixed_weight[i];
        }
        *s.contrast = contrast;
    }
    const std::pair<const std::vector<float>*, float*> results[] = {
        {&m.values, s.values}, {&m.shape, s.drawing}, {&m.model, s.model},
        {&m.gain, s.gain},     {&m.dark, s.dark},       {&m.weights, s.weights}};
    for (const auto& each : results)
        for (int j = 0; j < n; ++j) std::copy_n(&(*each.first)[j * wide], n, each.second + j * n);
}

}  // namespace

void Aligner::run(const Pyramid& pyramid, const Lens& lens, std::vector<AlignedMarker>& markers, int steps,
                  unsigned redraw, const Thresholds& limit) const {
    Marker marker(*this);
    for (const AlignedMarker& each : markers) align(marker, pyramid, lens, steps, redraw, limit, each);
}

void Aligner::sample(const Pyramid& pyramid, const Lens& lens, const double* h, std::int64_t level,
                     float* values) const {
    Marker marker(*this);
    marker.sample(pyramid.atlas, pyramid.levels[level], lens, h);
    for (int j = 0; j < count; ++j) std::copy_n(&marker.values[j * marker.wide], count, values + j * count);
}
