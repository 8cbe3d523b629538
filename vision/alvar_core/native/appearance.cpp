// Appearance.likeness and .features of detection/acceptance.py, and Reader.read of detection/reading.py.
#include <cstring>
#include <vector>

#include "algebra.h"
#include "image.h"
#include "steps.h"

namespace {

using namespace alvar;

constexpr int kSmooth = 6, kLight = 4;  // functions that are removed from the data cells, from the region that is read
constexpr int kStrips = 4;

double without_noise(double energy, double noise, double max_share) {
    return energy - std::min(noise, max_share * energy);
}

// Removes the part of `values` (count,) that an orthonormal basis (count, functions) explains.
void remove_part(float* values, const float* basis, int count, int functions) {
    double shares[kSmooth] = {};
    for (int i = 0; i < count; ++i)
        for (int k = 0; k < functions; ++k) shares[k] += double(values[i]) * basis[i * functions + k];
    for (int i = 0; i < count; ++i) {
        double part = 0;
        for (int k = 0; k < functions; ++k) part += shares[k] * basis[i * functions + k];
        values[i] -= part;
    }
}

// Normalised correlation of values with a drawing, both (samples,), weighted by shares
double correlation(const float* values, const float* drawing, const float* share, int samples, double noise,
                              double max_noise_share) {
    double v = 0, t = 0, vv = 0, tt = 0, vt = 0;
    for (int i = 0; i < samples; ++i) {
        const double a = values[i], b = drawing[i], w = share[i];
        v += w * a, t += w * b, vv += w * a * a, tt += w * b * b, vt += w * a * b;
    }
    const double energy = without_noise(vv - v * v, noise * noise, max_noise_share);
    return (vt - v * t) / std::sqrt(energy * (tt - t * t) + 1e-6);
}

// 2 F(z) - 1 for the normal distribution F, by alignment.NORMAL_STEP
float step_of(float z, const float* normal_step) {
    const float zz = std::min(z * z, 30.0f);
    return std::tanh(z * (normal_step[0] + zz * (normal_step[1] + zz * normal_step[2])));
}

// The index of the word that fits best, of words (cells, all_words), 1 for white; sets the fits of it and of the next.
int best_word(const double* gram, const double* matched, int cells, double energy, int all_words,
                         const float* words, float* first, float* second) {
    constexpr int kBatch = 64;
    int best = 0;
    *first = *second = -1e9f;
    for (int w = 0; w < all_words; w += kBatch) {
        const int some = std::min(kBatch, all_words - w);
        float sum[kBatch] = {}, power[kBatch] = {}, with[kBatch];
        for (int p = 0; p < cells; ++p) {
            const float own = gram[p * cells + p], value = matched[p];
            for (int i = 0; i < some; ++i) with[i] = own;
            for (int q = 0; q < p; ++q) {
                const float twice = 2 * gram[p * cells + q];
                for (int i = 0; i < some; ++i) with[i] += twice * words[q * all_words + w + i];
            }
            for (int i = 0; i < some; ++i) {
                const float white = words[p * all_words + w + i];
                sum[i] += white * value, power[i] += white * with[i];
            }
        }
        for (int i = 0; i < some; ++i) {
            const float fit = sum[i] / std::sqrt(std::max<double>(power[i], 1e-6) * (energy + 1e-6));
            if (fit > *first) *second = *first, *first = fit, best = w + i;
            else if (fit > *second) *second = fit;
        }
    }
    return best;
}

}  // namespace

// Writes likeness, detail, outside, bad_inside, bad_rim, kept (6, markers) of Features. All of `values`, `drawing`,
// `model`, `gain`, `weights` are (markers, samples); `share` (samples,); `group` (samples,): the cell that a sample is
// in, cells^2 and more for the four strips around the marker, or -1.
extern "C" void alvar_features(int markers, int samples, const float* values, const float* drawing, const float* model,
                               const float* gain, const float* weights, const float* share, double all_weight,
                               const double* noise, int data_count, const std::int64_t* data, const float* smooth,
                               int cells, const std::int32_t* group, const std::uint8_t* is_data,
                               double max_noise_share, double bad_cell, double* out) {
    const int groups = cells * cells + kStrips;
    std::vector<float> v(data_count), t(data_count);
    std::vector<double> mean(groups), size(groups);
    for (int m = 0; m < markers; ++m, values += samples, drawing += samples, model += samples, gain += samples,
             weights += samples, ++out) {
        out[0] = correlation(values, drawing, share, samples, noise[m], max_noise_share);
        for (int i = 0; i < data_count; ++i) v[i] = values[data[i]], t[i] = drawing[data[i]];
        remove_part(v.data(), smooth, data_count, kSmooth);
        remove_part(t.data(), smooth, data_count, kSmooth);
        double vv = 0, tt = 0, vt = 0;
        for (int i = 0; i < data_count; ++i)
            vv += double(v[i]) * v[i], tt += double(t[i]) * t[i], vt += double(v[i]) * t[i];
        out[markers] = vt / std::sqrt(without_noise(vv, data_count * noise[m] * noise[m], max_noise_share) * tt + 1e-6);
        std::fill(mean.begin(), mean.end(), 0.0), std::fill(size.begin(), size.end(), 0.0);
        double kept = 0;
        for (int i = 0; i < samples; ++i) {
            kept += weights[i];
            if (group[i] < 0) continue;
            mean[group[i]] += (values[i] - model[i]) / gain[i];
            size[group[i]] += 1;
        }
        int inside = 0, rim = 0;
        for (int i = 0; i < cells * cells; ++i)
            if (std::fabs(mean[i] / size[i]) > bad_cell) ++(is_data[i] ? inside : rim);
        double outside = 1e9;
        for (int i = cells * cells; i < groups; ++i) outside = std::min(outside, mean[i] / size[i]);
        out[2 * markers] = outside, out[3 * markers] = inside, out[4 * markers] = rim;
        out[5 * markers] = kept / all_weight;
    }
}

// Writes fit and gap (2, markers) and the word (markers,) of the best of `words` (resolution^2, all_words). `values`
// (markers, side, side) [greys]: those of the region that is read; `line` (side,) [cells]; `light` (side^2, 4);
// `variance` (2, markers) [cells^2]: of the blur along x and y; `noise` (markers,).
extern "C" void alvar_read(int markers, int side, const float* values, const float* line, int resolution,
                           const float* light, const float* normal_step, const double* variance, const double* noise,
                           int all_words, const float* words, double max_noise_share, double* out, std::int64_t* best) {
    const int cells = resolution * resolution, count = side * side;
    std::vector<float> grey(count), cover[2];
    float first, second;
    std::vector<double> gram(cells * cells), matched(cells), shares(cells * kLight);
    for (auto& each : cover) each.resize(side * resolution);
    for (int m = 0; m < markers; ++m) {
        for (int axis = 0; axis < 2; ++axis) {
            const float s = 1 / std::sqrt(variance[axis * markers + m]);
            for (int i = 0; i < side; ++i) {
                float before = 0.5f * step_of((line[i] + 0.5f * resolution) * s, normal_step);
                for (int c = 0; c < resolution; ++c) {
                    const float after = 0.5f * step_of((line[i] + 0.5f * resolution - c - 1) * s, normal_step);
                    cover[axis][i * resolution + c] = before - after;
                    before = after;
                }
            }
        }
        const float *ex = cover[0].data(), *ey = cover[1].data();
        std::copy(values + std::size_t(m) * count, values + std::size_t(m + 1) * count, grey.begin());
        remove_part(grey.data(), light, count, kLight);
        double energy = 0, xx[25], yy[25];  // resolution 5
        for (const float each : grey) energy += double(each) * each;
        energy = without_noise(energy, count * noise[m] * noise[m], max_noise_share);
        std::fill(matched.begin(), matched.end(), 0.0), std::fill(shares.begin(), shares.end(), 0.0);
        for (int j = 0; j < side; ++j)
            for (int c = 0; c < resolution; ++c) {
                double of_row = 0, of_light[kLight] = {};
                for (int i = 0; i < side; ++i) {
                    const double e = ex[i * resolution + c];
                    of_row += e * grey[j * side + i];
                    for (int k = 0; k < kLight; ++k) of_light[k] += e * light[(j * side + i) * kLight + k];
                }
                for (int r = 0; r < resolution; ++r) {
                    const double e = ey[j * resolution + r];
                    matched[r * resolution + c] += e * of_row;
                    for (int k = 0; k < kLight; ++k) shares[(r * resolution + c) * kLight + k] += e * of_light[k];
                }
            }
        for (int a = 0; a < resolution; ++a)
            for (int b = 0; b < resolution; ++b) {
                double x = 0, y = 0;
                for (int i = 0; i < side; ++i) {
                    x += double(ex[i * resolution + a]) * ex[i * resolution + b];
                    y += double(ey[i * resolution + a]) * ey[i * resolution + b];
                }
                xx[a * resolution + b] = x, yy[a * resolution + b] = y;
            }
        for (int p = 0; p < cells; ++p)
            for (int q = 0; q < cells; ++q) {
                double lit = 0;
                for (int k = 0; k < kLight; ++k) lit += shares[p * kLight + k] * shares[q * kLight + k];
                gram[p * cells + q] = yy[p / resolution * resolution + q / resolution]
                                      * xx[p % resolution * resolution + q % resolution] - lit;
            }
        best[m] = best_word(gram.data(), matched.data(), cells, energy, all_words, words, &first, &second);
        out[m] = first, out[markers + m] = first - second;
    }
}
