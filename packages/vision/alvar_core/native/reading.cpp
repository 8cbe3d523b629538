// reading.CoarseDecoder and reading.Reader
#include <cstring>

#include "algebra.h"
#include "energy.h"
#include "sampling.h"

namespace {

using namespace alvar;

// sums (count, columns) = values (count, rows) times a matrix (rows, columns): the matrix is read once, and the sums
// once for three of its rows; `count` is at most kBatch
constexpr int kBatch = 4, kTogether = 3;

void times(const float* values, const float* __restrict matrix, int count, int rows, int columns,
           float* __restrict sums) {
    std::fill(sums, sums + count * columns, 0.0f);
    int k = 0;
    for (; k + kTogether <= rows; k += kTogether) {
        const float* row = matrix + std::size_t(k) * columns;
        for (int b = 0; b < count; ++b) {
            const float *of = values + b * rows + k, x = of[0], y = of[1], z = of[2];
            float* sum = sums + b * columns;
            for (int i = 0; i < columns; ++i) sum[i] += x * row[i] + y * row[columns + i] + z * row[2 * columns + i];
        }
    }
    for (; k < rows; ++k)
        for (int b = 0; b < count; ++b)
            for (int i = 0; i < columns; ++i)
                sums[b * columns + i] += values[b * rows + k] * matrix[std::size_t(k) * columns + i];
}

constexpr int kAlong = 5, kSides = 4, kPlaces = kAlong * kSides;  // as CoarseDecoder.ALONG

// The threshold that the border misses: contrast with its outside, or darkness everywhere
Shortfall missed_by_rim(const Image& smooth, const float* h, const float* rim, const Thresholds& limit) {
    float grey[2 * kPlaces], step[kPlaces], sorted[kPlaces], sides[kSides];
    read(smooth, h, rim, 2 * kPlaces, 0, 2 * kPlaces, grey);
    for (int i = 0; i < kPlaces; ++i) sorted[i] = step[i] = grey[i] - grey[kPlaces + i];
    for (int k = 0; k < kSides; ++k) sides[k] = nth(sorted + k * kAlong, kAlong, kAlong / 2);
    const float contrast = nth(sides, kSides, 1);
    const float least = std::max<float>(limit.MIN_RIM_STEP_SHARE * contrast, limit.MIN_RIM_STEP);
    int dark = 0;
    for (const float each : step) dark += each > least;
    if (!(contrast > limit.MIN_RIM_CONTRAST)) return {"MIN_RIM_CONTRAST", contrast, limit.MIN_RIM_CONTRAST};
    if (!(dark > limit.MIN_DARK_RIM * kPlaces)) return {"MIN_DARK_RIM", double(dark) / kPlaces, limit.MIN_DARK_RIM};
    return {nullptr, 0, 0};
}

constexpr int kResolution = 5, kLight = 4;  // functions that are removed from the region of the cells

// 2 F(z) - 1 for the normal distribution F
float step_of(float z) {
    const float zz = std::min(z * z, 30.0f);
    return std::tanh(z * (kNormalStep[0] + zz * (kNormalStep[1] + zz * kNormalStep[2])));
}

// The index of the word that fits best, of words (cells, all_words), 1 for white; sets the fits of it and of the next.
int best_word(const double* gram, const double* matched, int cells, double energy, int all_words, const float* words,
              float* first, float* second) {
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

// Divides the sums of greys (points,) times words (all_words,) by how much the greys of each word's cells vary.
void CoarseDecoder::scale(const float* grey, float* of_words) const {
    const int groups = known.size() / points;
    for (int group = 0; group < groups; ++group) {
        const float* counts = &known[group * points];
        double sum = 0, square = 0, all = 0;
        for (int i = 0; i < points; ++i)
            sum += grey[i] * counts[i], square += double(grey[i]) * grey[i] * counts[i], all += counts[i];
        const double spread = std::sqrt(std::max(square - sum * sum / all, 1.0));
        if (groups > 1) of_words[group] /= spread;
        else
            for (int w = 0; w < all_words; ++w) of_words[w] /= spread;
    }
}

CoarseMatch CoarseDecoder::match(const Image& smooth, int count, const double* quads, const Thresholds& limit,
                                 Trail* trail) const {
    CoarseMatch found;
    for (int m = 0; m < count; ++m) {
        double h[9];
        float single[9];
        from_square(quads + 8 * m, half, h);
        std::copy(h, h + 9, single);
        const Shortfall missed = missed_by_rim(smooth, single, rim.data(), limit);
        if (missed.threshold) {
            end_at(trail, quads + 8 * m, missed);
            continue;
        }
        found.kept.push_back(m);
        found.h.insert(found.h.end(), h, h + 9);
    }
    const std::size_t all = found.kept.size();
    found.word.resize(all), found.fit.resize(all), found.score_gap.resize(all);
    std::vector<int> sharp, small;  // places in `kept`
    const double least = 2 * half * limit.SMALL_CELL;
    for (std::size_t k = 0; k < all; ++k) {
        const bool is_small = !blurred.empty() && std::fabs(area(quads + 8 * found.kept[k])) < least * least;
        (is_small ? small : sharp).push_back(k);
    }
    match_words(smooth, sharp, words, found);
    match_words(smooth, small, blurred, found);
    return found;
}

// Sets the best words of some of the quads that are kept.
void CoarseDecoder::match_words(const Image& smooth, const std::vector<int>& places, const std::vector<float>& drawn,
                                CoarseMatch& found) const {
    const int all = places.size();
    std::vector<float> grey(kBatch * points), of_words(kBatch * all_words);
    for (int first = 0; first < all; first += kBatch) {
        const int some = std::min(kBatch, all - first);
        for (int k = 0; k < some; ++k) {
            float single[9];
            std::copy_n(&found.h[9 * places[first + k]], 9, single);
            read(smooth, single, cells.data(), points, 0, points, &grey[k * points]);
        }
        times(grey.data(), drawn.data(), some, points, all_words, of_words.data());
        for (int k = 0; k < some; ++k) {
            float *fits = &of_words[k * all_words], score_gap;
            const int place = places[first + k];
            scale(&grey[k * points], fits);
            found.word[place] = best_of(fits, all_words, &score_gap);
            found.fit[place] = fits[found.word[place]], found.score_gap[place] = score_gap;
        }
    }
}

// The fit of the best word to the cells of a quad (4, 2) that are `spread` times as far apart.
double CoarseDecoder::fit(const Image& smooth, const double* quad, double spread) const {
    double h[9];
    float single[9];
    from_square(quad, half / spread, h);  // of places that are so many times as large
    std::copy(h, h + 9, single);
    std::vector<float> grey(points), of_words(all_words);
    read(smooth, single, cells.data(), points, 0, points, grey.data());
    times(grey.data(), words.data(), 1, points, all_words, of_words.data());
    scale(grey.data(), of_words.data());
    return *std::max_element(of_words.begin(), of_words.begin() + all_words);
}

Shortfall CoarseDecoder::other_margin(const Image& smooth, const double* real_corners) const {
    const double own = fit(smooth, real_corners, 1), narrower = fit(smooth, real_corners, half / (half - 1));
    if (narrower > own) return {"NARROWER_MARGIN", own, narrower};
    const double wider = fit(smooth, real_corners, half / (half + 1));
    if (wider > own) return {"WIDER_MARGIN", own, wider};
    return {nullptr, 0, 0};
}

void alvar::coverage(const float* line, int count, int cells, double variance, float* out) {
    const float s = 1 / std::sqrt(variance);
    for (int i = 0; i < count; ++i) {
        float before = 0.5f * step_of((line[i] + 0.5f * cells) * s);
        for (int c = 0; c < cells; ++c) {
            const float after = 0.5f * step_of((line[i] + 0.5f * cells - c - 1) * s);
            out[i * cells + c] = before - after;
            before = after;
        }
    }
}

Reader::Read Reader::read(const float* values, double xx, double yy, double noise, const Thresholds& limit) const {
    constexpr int cells = kResolution * kResolution;
    const int count = side * side;
    std::vector<float> grey(values, values + count), cover[2];
    float first, second;
    double gram[cells * cells], matched[cells], shares[cells * kLight], by_x[cells], by_y[cells];
    for (auto& each : cover) each.resize(side * kResolution);
    coverage(line.data(), side, kResolution, xx, cover[0].data());
    coverage(line.data(), side, kResolution, yy, cover[1].data());
    const float *ex = cover[0].data(), *ey = cover[1].data();
    remove_part(grey.data(), light.data(), count, kLight);
    double energy = 0;
    for (const float each : grey) energy += double(each) * each;
    energy = without_noise(energy, count * noise * noise, limit.MAX_NOISE_SHARE);
    std::fill(matched, matched + cells, 0.0), std::fill(shares, shares + cells * kLight, 0.0);
    for (int j = 0; j < side; ++j)
        for (int c = 0; c < kResolution; ++c) {
            double of_row = 0, of_light[kLight] = {};
            for (int i = 0; i < side; ++i) {
                const double e = ex[i * kResolution + c];
                of_row += e * grey[j * side + i];
                for (int k = 0; k < kLight; ++k) of_light[k] += e * light[(j * side + i) * kLight + k];
            }
            for (int r = 0; r < kResolution; ++r) {
                const double e = ey[j * kResolution + r];
                matched[r * kResolution + c] += e * of_row;
                for (int k = 0; k < kLight; ++k) shares[(r * kResolution + c) * kLight + k] += e * of_light[k];
            }
        }
    for (int a = 0; a < kResolution; ++a)
        for (int b = 0; b < kResolution; ++b) {
            double x = 0, y = 0;
            for (int i = 0; i < side; ++i) {
                x += double(ex[i * kResolution + a]) * ex[i * kResolution + b];
                y += double(ey[i * kResolution + a]) * ey[i * kResolution + b];
            }
            by_x[a * kResolution + b] = x, by_y[a * kResolution + b] = y;
        }
    for (int p = 0; p < cells; ++p)
        for (int q = 0; q < cells; ++q) {
            double lit = 0;
            for (int k = 0; k < kLight; ++k) lit += shares[p * kLight + k] * shares[q * kLight + k];
            gram[p * cells + q] = by_y[p / kResolution * kResolution + q / kResolution]
                                  * by_x[p % kResolution * kResolution + q % kResolution] - lit;
        }
    const int best = best_word(gram, matched, cells, energy, all_words, words.data(), &first, &second);
    return {best, first, first - second};
}
