// local_contrast.LocalDecoder
#include <cstring>

#include "algebra.h"
#include "sampling.h"

namespace {

using namespace alvar;

constexpr int kAround = 3;  // pairs of points of an edge, as LocalDecoder.ALONG

// sums (columns) = values (rows) times a matrix (rows, columns) of 0 and 1
void sum_chosen(const float* values, const std::uint8_t* matrix, int rows, int columns, float* sums) {
    std::fill(sums, sums + columns, 0.0f);
    int k = 0;
    for (; k + 4 <= rows; k += 4) {
        const float a = values[k], b = values[k + 1], c = values[k + 2], d = values[k + 3];
        const std::uint8_t* row = matrix + std::size_t(k) * columns;
        for (int i = 0; i < columns; ++i)
            sums[i] += a * row[i] + b * row[i + columns] + (c * row[i + 2 * columns] + d * row[i + 3 * columns]);
    }
    for (; k < rows; ++k)
        for (int i = 0; i < columns; ++i) sums[i] += values[k] * matrix[std::size_t(k) * columns + i];
}

// Of `count` of all pairs of points, from `first` on, (after - before) / (after + before)
void contrasts(const Image& smooth, const float* h, const float* points, int pairs, int first, int count,
               double dark_grey, float* seen, float* after) {
    read(smooth, h, points, 2 * pairs, first, count, seen);
    read(smooth, h, points, 2 * pairs, pairs + first, count, after);
    const float dark = dark_grey;
    for (int i = 0; i < count; ++i) seen[i] = (after[i] - seen[i]) / (after[i] + seen[i] + dark);
}

// Sets the share of the rim that is an edge, and its typical contrast; both to 0 once the share must be below `least`.
void rim_of(const Image& smooth, const float* h, int pairs, const float* points, const Thresholds& limit,
            double least_share, float* buffer, double* share, double* contrast) {
    constexpr int kSome = 36;
    float *seen = buffer, *other = buffer + pairs;
    int none = 0;
    for (int first = 0; first < pairs; first += kSome) {
        const int some = std::min(kSome, pairs - first);
        contrasts(smooth, h, points, pairs, first, some, limit.DARK_GREY, seen + first, other);
        for (int i = first; i < first + some; ++i) none += !(seen[i] > limit.MIN_LOCAL_CONTRAST);
        if (none > (1 - least_share) * pairs) {
            *share = *contrast = 0;
            return;
        }
    }
    std::copy(seen, seen + pairs, other);
    const float upper = nth(other, pairs, pairs / 2);
    const float lower = pairs % 2 ? upper : *std::max_element(other, other + pairs / 2);
    *contrast = 0.5 * (lower + upper);
    const float least = std::max(limit.MIN_LOCAL_SHARE * *contrast, limit.MIN_LOCAL_CONTRAST);
    int shown = 0;
    for (int i = 0; i < pairs; ++i) shown += seen[i] > least;
    *share = double(shown) / pairs;
}

}  // namespace

void alvar::contrasts(const Image& smooth, const double* h, const float* points, int pairs, const Thresholds& limit,
                      float* seen) {
    float single[9];
    std::copy(h, h + 9, single);
    std::vector<float> after(pairs);
    ::contrasts(smooth, single, points, pairs, 0, pairs, limit.DARK_GREY, seen, after.data());
}

void LocalDecoder::rim_of(const Image& smooth, const double* h, const Thresholds& limit, double* share,
                          double* contrast) const {
    const int pairs = rim.size() / 6;
    float single[9];
    std::copy(h, h + 9, single);
    std::vector<float> buffer(2 * pairs);
    ::rim_of(smooth, single, pairs, rim.data(), limit, limit.MIN_LOCAL_RIM, buffer.data(), share, contrast);
}

LocalMatch LocalDecoder::match(const Image& smooth, const double* h, const Thresholds& limit) const {
    const int rim_pairs = rim.size() / 6, pairs = kAround * edges;
    std::vector<float> buffer(2 * std::max(pairs, rim_pairs)), cost(3 * edges), fit(all_words);
    const float cap = limit.MAX_EDGE_COST;
    LocalMatch found;
    float single[9], score_gap;
    std::copy(h, h + 9, single);
    ::rim_of(smooth, single, rim_pairs, rim.data(), limit, 0.0, buffer.data(), &found.rim, &found.contrast);
    ::contrasts(smooth, single, points.data(), pairs, 0, pairs, limit.DARK_GREY, &buffer[0], &buffer[pairs]);
    const float scale = 1 / std::max(found.contrast, limit.MIN_LOCAL_CONTRAST);
    int stepped = 0, in_code = 0;
    for (int e = 0; e < edges; ++e) {
        const float seen = nth(&buffer[kAround * e], kAround, 1) * scale;
        if (of_code[e]) buffer[in_code++] = seen;  // edges before this one are not needed any more
        else stepped += std::fabs(seen) >= limit.MAX_PLAIN_CONTRAST;
    }
    for (int k = 0; k < in_code; ++k) {
        const float seen = buffer[k];
        cost[k] = std::min(std::max(1 + seen, 0.0f), cap);
        cost[in_code + k] = std::min(std::fabs(seen), cap);
        cost[2 * in_code + k] = std::min(std::max(1 - seen, 0.0f), cap);
    }
    sum_chosen(cost.data(), costs.data(), 3 * in_code, all_words, fit.data());
    for (float& each : fit) each = 1 - each / (cap * in_code);
    found.word = best_of(fit.data(), all_words, &score_gap);
    found.plain = 1 - double(stepped) / std::max(1, edges - in_code);
    found.fit = fit[found.word], found.score_gap = score_gap;
    return found;
}
