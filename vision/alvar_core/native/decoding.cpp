// CoarseDecoder.match of detection/reading.py, and LocalDecoder.rim and .match of detection/local_contrast.py.
#include <cstring>
#include <vector>

#include "algebra.h"
#include "image.h"
#include "steps.h"

namespace {

using namespace alvar;

// Greys at homogeneous points (3, stride), of which `count` are read from `first` on.
void read(const Image& smooth, const float* h, const float* points, int stride, int first, int count,
                     float* grey) {
    float u[kBlock], v[kBlock];
    for (int i = 0; i < count; i += kBlock) {
        const int some = std::min(kBlock, count - i);
        for (int k = 0; k < some; ++k) {
            const float* p = points + first + i + k;
            const float x = p[0], y = p[stride], w = 1 / (h[6] * x + h[7] * y + h[8]);
            u[k] = (h[0] * x + h[1] * y + h[2]) * w, v[k] = (h[3] * x + h[4] * y + h[5]) * w;
        }
        smooth.read(u, v, some, grey + i);
    }
}

// sums (kBatch, columns) = values (kBatch, rows) times a matrix (rows, columns): the matrix is read once
constexpr int kBatch = 4;

void times(const float* values, const float* matrix, int rows, int columns, float* sums) {
    std::fill(sums, sums + kBatch * columns, 0.0f);
    for (int k = 0; k < rows; ++k) {
        const float a = values[k], b = values[rows + k], c = values[2 * rows + k], d = values[3 * rows + k];
        const float* row = matrix + std::size_t(k) * columns;
        float *p = sums, *q = sums + columns, *r = sums + 2 * columns, *s = sums + 3 * columns;
        for (int i = 0; i < columns; ++i) p[i] += a * row[i], q[i] += b * row[i], r[i] += c * row[i], s[i] += d * row[i];
    }
}

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

// The index of the largest of `count` numbers; sets by how much it is larger than the next one.
int best_of(const float* numbers, int count, float* gap) {
    int best = 0;
    float second = -1e9f;
    for (int i = 1; i < count; ++i)
        if (numbers[i] > numbers[best]) second = numbers[best], best = i;
        else if (numbers[i] > second) second = numbers[i];
    *gap = numbers[best] - second;
    return best;
}

struct CoarseLimits {  // the order of reading.py's limits
    double half, step_share, min_step, min_contrast, min_dark;
};

constexpr int kAlong = 5, kSides = 4, kPlaces = kAlong * kSides;  // of CoarseDecoder.ALONG

bool has_dark_rim(const Image& smooth, const float* h, const float* rim, const CoarseLimits& limit) {
    float grey[2 * kPlaces], step[kPlaces], sorted[kPlaces], sides[kSides];
    read(smooth, h, rim, 2 * kPlaces, 0, 2 * kPlaces, grey);
    for (int i = 0; i < kPlaces; ++i) sorted[i] = step[i] = grey[i] - grey[kPlaces + i];
    for (int k = 0; k < kSides; ++k) sides[k] = nth(sorted + k * kAlong, kAlong, kAlong / 2);
    const float contrast = nth(sides, kSides, 1);
    const float least = std::max<float>(limit.step_share * contrast, limit.min_step);
    int dark = 0;
    for (const float each : step) dark += each > least;
    return contrast > limit.min_contrast && dark > limit.min_dark * kPlaces;
}

struct LocalLimits {  // the order of local_contrast.py's limits
    double dark_grey, min_share, min_contrast, max_plain, max_cost;
};

// Of `count` of all pairs of points, from `first` on, (after - before) / (after + before)
void contrasts(const Image& smooth, const float* h, const float* points, int pairs, int first, int count,
               double dark_grey, float* seen, float* after) {
    read(smooth, h, points, 2 * pairs, first, count, seen);
    read(smooth, h, points, 2 * pairs, pairs + first, count, after);
    const float dark = dark_grey;
    for (int i = 0; i < count; ++i) seen[i] = (after[i] - seen[i]) / (after[i] + seen[i] + dark);
}

// Sets the share of the rim that is an edge, and its typical contrast; both to 0 once the share must be below `least`.
void rim_of(const Image& smooth, const float* h, int pairs, const float* points, const LocalLimits& limit,
            double least_share, float* buffer, double* share, double* contrast) {
    constexpr int kSome = 36;
    float *seen = buffer, *other = buffer + pairs;
    int none = 0;
    for (int first = 0; first < pairs; first += kSome) {
        const int some = std::min(kSome, pairs - first);
        contrasts(smooth, h, points, pairs, first, some, limit.dark_grey, seen + first, other);
        for (int i = first; i < first + some; ++i) none += !(seen[i] > limit.min_contrast);
        if (none > (1 - least_share) * pairs) {
            *share = *contrast = 0;
            return;
        }
    }
    std::copy(seen, seen + pairs, other);
    const float upper = nth(other, pairs, pairs / 2);
    const float lower = pairs % 2 ? upper : *std::max_element(other, other + pairs / 2);
    *contrast = 0.5 * (lower + upper);
    const float least = std::max(limit.min_share * *contrast, limit.min_contrast);
    int shown = 0;
    for (int i = 0; i < pairs; ++i) shown += seen[i] > least;
    *share = double(shown) / pairs;
}

}  // namespace

// Writes, for those of the quads (count, 4, 2) that have a dark rim: index, homography, and fit, gap (2, count) and
// index of the best of `words` (cells, all_words). Returns how many they are.
extern "C" int alvar_match_coarse(const std::uint8_t* greys, std::int64_t stride, int width, int height, int count,
                                  const double* quads, const double* limits, const float* rim, int cells,
                                  const float* cell_points, int all_words, const float* words, std::int64_t* kept,
                                  double* homographies, double* fits, std::int64_t* best) {
    const Image smooth = {greys, stride, width, height};
    CoarseLimits limit;
    std::memcpy(&limit, limits, sizeof limit);
    std::vector<float> grey(kBatch * cells), fit(kBatch * all_words);
    int found = 0;
    for (int m = 0; m < count; ++m) {
        double* h = homographies + 9 * found;
        from_square(quads + 8 * m, limit.half, h);
        float single[9];
        std::copy(h, h + 9, single);
        if (has_dark_rim(smooth, single, rim, limit)) kept[found++] = m;
    }
    for (int first = 0; first < found; first += kBatch) {
        const int some = std::min(kBatch, found - first);
        for (int k = 0; k < some; ++k) {
            float single[9];
            std::copy(homographies + 9 * (first + k), homographies + 9 * (first + k + 1), single);
            read(smooth, single, cell_points, cells, 0, cells, &grey[k * cells]);
        }
        times(grey.data(), words, cells, all_words, fit.data());
        for (int k = 0; k < some; ++k) {
            double sum = 0, square = 0;
            for (int i = k * cells; i < (k + 1) * cells; ++i) sum += grey[i], square += double(grey[i]) * grey[i];
            const double spread = std::sqrt(std::max(square - sum * sum / cells, 1.0));
            const float* of_words = &fit[k * all_words];
            float gap;
            const int word = best_of(of_words, all_words, &gap);
            best[first + k] = word;
            fits[first + k] = of_words[word] / spread, fits[count + first + k] = gap / spread;
        }
    }
    return found;
}

// The fit of the best word to the cells of a quad (4, 2) that are `spread` times as far apart.
extern "C" double alvar_coarse_fit(const std::uint8_t* greys, std::int64_t stride, int width, int height,
                                   const double* quad, double half, double spread, int cells, const float* cell_points,
                                   int all_words, const float* words) {
    const Image smooth = {greys, stride, width, height};
    double h[9];
    float single[9];
    from_square(quad, half / spread, h);  // of places that are so many times as large
    std::copy(h, h + 9, single);
    std::vector<float> grey(kBatch * cells), fit(kBatch * all_words);
    read(smooth, single, cell_points, cells, 0, cells, grey.data());
    times(grey.data(), words, cells, all_words, fit.data());
    double sum = 0, square = 0;
    for (int i = 0; i < cells; ++i) sum += grey[i], square += double(grey[i]) * grey[i];
    return *std::max_element(fit.begin(), fit.begin() + all_words) / std::sqrt(std::max(square - sum * sum / cells, 1.0));
}

// Writes the contrasts (markers, pairs) at points (3, 2 * pairs).
extern "C" void alvar_contrasts(const std::uint8_t* greys, std::int64_t stride, int width, int height, int markers,
                                const float* h, int pairs, const float* points, double dark_grey, float* out) {
    const Image smooth = {greys, stride, width, height};
    std::vector<float> buffer(pairs);
    for (int m = 0; m < markers; ++m)
        contrasts(smooth, h + 9 * m, points, pairs, 0, pairs, dark_grey, out + m * pairs, buffer.data());
}

// Writes share and contrast (2, markers) of the rims of markers at h (markers, 3, 3), where the share is `least` or more.
extern "C" void alvar_local_rims(const std::uint8_t* greys, std::int64_t stride, int width, int height, int markers,
                                 const float* h, int pairs, const float* points, const double* limits, double least,
                                 double* out) {
    const Image smooth = {greys, stride, width, height};
    LocalLimits limit;
    std::memcpy(&limit, limits, sizeof limit);
    std::vector<float> buffer(2 * pairs);
    for (int m = 0; m < markers; ++m)
        rim_of(smooth, h + 9 * m, pairs, points, limit, least, buffer.data(), out + m, out + markers + m);
}

// Writes rim, contrast, plain, fit, gap (5, markers) of a LocalMatch, and the words (markers,). An edge has kAround
// pairs of points; `of_code` (edges,) are those of the code; costs (3 * those, all_words): 1 where it counts.
extern "C" void alvar_match_local(const std::uint8_t* greys, std::int64_t stride, int width, int height, int markers,
                                  const float* h, int rim_pairs, const float* rim_points, int edges,
                                  const float* points, const std::uint8_t* of_code, int all_words, const std::uint8_t* costs,
                                  const double* limits, double* out, std::int64_t* words) {
    constexpr int kAround = 3;  // of LocalDecoder.ALONG
    const Image smooth = {greys, stride, width, height};
    LocalLimits limit;
    std::memcpy(&limit, limits, sizeof limit);
    const int pairs = kAround * edges;
    std::vector<float> buffer(2 * std::max(pairs, rim_pairs)), cost(3 * edges), fit(all_words);
    const float cap = limit.max_cost;
    for (int m = 0; m < markers; ++m) {
        double* contrast = out + markers + m;
        rim_of(smooth, h + 9 * m, rim_pairs, rim_points, limit, 0.0, buffer.data(), out + m, contrast);
        contrasts(smooth, h + 9 * m, points, pairs, 0, pairs, limit.dark_grey, &buffer[0], &buffer[pairs]);
        const float scale = 1 / std::max(*contrast, limit.min_contrast);
        int stepped = 0, in_code = 0;
        for (int e = 0; e < edges; ++e) {
            const float seen = nth(&buffer[kAround * e], kAround, 1) * scale;
            if (of_code[e]) buffer[in_code++] = seen;  // edges before this one are not needed any more
            else stepped += std::fabs(seen) >= limit.max_plain;
        }
        for (int k = 0; k < in_code; ++k) {
            const float seen = buffer[k];
            cost[k] = std::min(std::max(1 + seen, 0.0f), cap);
            cost[in_code + k] = std::min(std::fabs(seen), cap);
            cost[2 * in_code + k] = std::min(std::max(1 - seen, 0.0f), cap);
        }
        sum_chosen(cost.data(), costs, 3 * in_code, all_words, fit.data());
        float gap;
        for (float& each : fit) each = 1 - each / (cap * in_code);
        words[m] = best_of(fit.data(), all_words, &gap);
        out[2 * markers + m] = 1 - double(stepped) / std::max(1, edges - in_code);
        out[3 * markers + m] = fit[words[m]], out[4 * markers + m] = gap;
    }
}
