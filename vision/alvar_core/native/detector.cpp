// Detector._in_even_light of detection/detector.py for markers of resolution 5: all steps on all candidates in one call.
//
// What needs a closer look (another reading than the drawing's, covered cells) is only named, so that the rare and long
// steps exist once, in Python. Names and formulas are those of detector.py, acceptance.py and candidates.py.
#include <cmath>
#include <cstring>
#include <vector>

#include "algebra.h"
#include "image.h"
#include "steps.h"

namespace {

using namespace alvar;

constexpr int kAllWords = 1024, kNumbers = 256, kResolution = 5;

struct Demand {
    double fit, surplus, detail;
};

// The order of compiled_search.py's limits
struct Limits {
    double min_coarse_fit, gap_weight, max_aligned, same_quad, start_blur, next_level[2], steps, well_read_fit,
        well_read_gap;
    double sampled_noise, min_area, min_likeness, max_blur, sure_fit, sure_gap, contrast_spare, changed_fit;
    Demand code_covered, covered, clear, unlike, sure;
    double code_covered_cells, wide_gap, covered_cells, clear_likeness, best_fit, min_gap, min_kept, max_bad_rim,
        min_outside, whole_likeness, sure_kept, sure_outside, sure_margin_detail, max_pose_error, max_noise_share,
        bad_cell, overlap;
};

// The order of compiled_search.py's constants
struct Constants {
    const double* limits;
    const double* side_limits;
    // reading.CoarseDecoder
    const double* coarse_limits;
    const float *rim, *cell_points, *coarse_words;
    // alignment.Aligner
    const float *line, *weight, *normal_step;
    const double* align_limits;
    const std::uint8_t* black_words;
    // acceptance.Appearance
    const float *share, *smooth_basis;
    const std::int64_t* data;
    const std::int32_t* group;
    const std::uint8_t* is_data;
    // reading.Reader
    const float *inside_line, *light, *words;
    // corners.CornerEstimator
    const double *scale, *edge_limits, *cell_limits, *corner_limits;
    // numbers: cells, samples in a row, data samples, points of the coarse decoding, first and count of those inside
    const std::int64_t* numbers;
    const double* all_weight;
};

struct Shape {
    int cells, count, data, coarse, first_inside, inside;
};

struct Features {
    double likeness, outside, detail, bad_inside, bad_rim, kept, contrast, noise, blur, fit, gap;
};

struct Record {  // a marker, the order of compiled_search.py's rows
    double number, corners[8], information[64], poses, solutions[2][14];
    Features features;
};

struct Start {  // of what needs a closer look: where its alignment starts, and its coarse decoding
    double h[9], word, blur, level, fit, gap;
};

struct Place {
    double x, y, side;
};

// A Start that is drawn as it was read, and the one that it was before
struct Changed {
    std::vector<Start> now, before;
};

struct Found {
    std::vector<Record> records;
    std::vector<Start> unsure;
    std::vector<Place> places, unsure_places;  // of the records, of what is unsure
};

// Whether the corners of two quads are nearer than `reach` along both axes, whichever comes first.
bool alike(const double* a, const double* b, double reach) {
    for (int turn = 0; turn < 4; ++turn) {
        bool near = true;
        for (int k = 0; near && k < 4; ++k)
            for (int axis = 0; axis < 2; ++axis)
                near = near && std::fabs(a[2 * k + axis] - b[2 * ((k + turn) % 4) + axis]) < reach;
        if (near) return true;
    }
    return false;
}

// candidates.distinct: of those that are worth an alignment, the best of each place
std::vector<int> distinct(const std::vector<double>& quads, const double* fit, const double* gap, int count,
                          const Limits& limit) {
    std::vector<int> order;
    for (int i = 0; i < count; ++i)
        if (fit[i] > limit.min_coarse_fit) order.push_back(i);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
        return fit[a] + limit.gap_weight * gap[a] > fit[b] + limit.gap_weight * gap[b];
    });
    std::vector<int> kept;
    for (const int i : order) {
        const double* quad = &quads[8 * i];
        const double side = std::sqrt(std::fabs(area(quad)));
        const bool known = std::any_of(kept.begin(), kept.end(), [&](int k) {
            return alike(quad, &quads[8 * k], limit.same_quad * std::min(side, std::sqrt(std::fabs(area(&quads[8 * k])))));
        });
        if (!known) kept.push_back(i);
    }
    if (kept.size() > limit.max_aligned) kept.resize(limit.max_aligned);
    return kept;
}

const Demand& demand(const Features& f, const Limits& limit) {
    if (f.bad_inside >= limit.code_covered_cells && f.gap > limit.wide_gap) return limit.code_covered;
    if (f.bad_rim + 2 * f.bad_inside >= limit.covered_cells) return limit.covered;
    return f.likeness > limit.clear_likeness ? limit.clear : limit.unlike;
}

bool accepted(const Features& f, const Limits& limit) {
    const Demand& asked = demand(f, limit);
    const double surplus = f.gap / (limit.best_fit - std::min(f.fit, 1.0));
    if (f.fit > limit.sure.fit && surplus > limit.sure.surplus && f.detail > limit.sure.detail)
        return f.kept > limit.sure_kept && f.outside > limit.sure_outside;
    return f.gap > limit.min_gap && f.kept > limit.min_kept && f.bad_rim <= limit.max_bad_rim
           && (f.outside > limit.min_outside || f.likeness > limit.whole_likeness) && f.fit > asked.fit
           && surplus > asked.surplus && f.detail > asked.detail;
}

bool may_be_covered(const Features& f, const Limits& limit) {
    return f.kept > limit.min_kept && f.bad_rim <= limit.max_bad_rim && f.bad_rim + f.bad_inside > 0
           && f.outside > limit.min_outside && f.fit > limit.changed_fit;
}

// The state of an alignment of `markers` markers, as in alignment.Alignment.
struct State {
    int markers, samples;
    std::vector<double> h, blur, numbers, normal;
    std::vector<std::int64_t> level;
    std::vector<std::uint8_t> black;
    std::vector<float> all;

    State(int count, int per_marker, int cells)
        : markers(count), samples(per_marker), h(9 * count), blur(count), numbers(3 * count), normal(225 * count),
          level(count), black(count * cells * cells), all(std::size_t(6) * count * per_marker) {}

    // values, template, model, gain, dark, weights of a marker
    float* of(int which, int m) { return &all[(std::size_t(which) * markers + m) * samples]; }
    double contrast(int m) const { return numbers[m]; }
    double noise(int m) const { return numbers[markers + m]; }
};

class Search {
public:
    Search(const Constants& constants, const Image& smooth, const Image& atlas, int height, const float* table,
           const double* lens_numbers, double noise)
        : is(constants), smooth(smooth), atlas(atlas), full{atlas.greys, atlas.stride, atlas.width, height},
          table(table), lens_numbers(lens_numbers), lens(lens_numbers), image_noise(noise) {
        std::memcpy(&limit, is.limits, sizeof limit);
        const std::int64_t* n = is.numbers;
        shape = {int(n[0]), int(n[1]), int(n[2]), int(n[3]), int(n[4]), int(n[5])};
    }

    // Finds markers among quads (count, 4, 2), whose sides are moved first; returns how many have such sides.
    int run(int count, double* quads, const double* sizes, std::vector<Record>& records, std::vector<Start>& starts,
             std::vector<double>& well_read) {
        count = alvar_refine_sides(smooth.greys, smooth.stride, smooth.width, smooth.height, is.side_limits, count, quads);
        std::vector<std::int64_t> kept(count), words(count);
        std::vector<double> all_h(9 * count), fits(2 * count);
        const int matched = alvar_match_coarse(
            smooth.greys, smooth.stride, smooth.width, smooth.height, count, quads, is.coarse_limits, is.rim, shape.coarse,
            is.cell_points, kAllWords, is.coarse_words, kept.data(), all_h.data(), fits.data(), words.data());
        std::vector<double> rest(8 * matched);
        for (int i = 0; i < matched; ++i) std::copy_n(quads + 8 * kept[i], 8, &rest[8 * i]);
        const double *fit = fits.data(), *gap = fits.data() + count;
        const std::vector<int> chosen = distinct(rest, fit, gap, matched, limit);
        if (chosen.empty()) return count;
        State state(chosen.size(), shape.count * shape.count, shape.cells);
        std::vector<Start> first(chosen.size());
        for (std::size_t m = 0; m < chosen.size(); ++m) {
            const int i = chosen[m];
            first[m] = start_of(&rest[8 * i], &all_h[9 * i], words[i], fit[i], gap[i]);
            if (fit[i] > limit.well_read_fit && gap[i] > limit.well_read_gap) {
                well_read.insert(well_read.end(), &rest[8 * i], &rest[8 * i] + 8);
                well_read.push_back(words[i]);
            }
        }
        align(state, first);
        Found found;
        Changed changed;
        judge(state, first, first, &changed, sizes, found);
        if (!changed.now.empty()) {
            State again(changed.now.size(), shape.count * shape.count, shape.cells);
            align(again, changed.now);
            judge(again, changed.now, changed.before, nullptr, sizes, found);
        }
        records = found.records;
        for (std::size_t k = 0; k < found.unsure.size(); ++k) {
            const Place& at = found.unsure_places[k];
            const bool known = std::any_of(found.places.begin(), found.places.end(), [&](const Place& other) {
                return std::hypot(other.x - at.x, other.y - at.y) < limit.overlap * at.side;
            });
            if (!known) starts.push_back(found.unsure[k]);
        }
        return count;
    }

private:
    const Constants& is;
    Limits limit;
    Shape shape;
    Image smooth, atlas, full;
    const float* table;
    const double* lens_numbers;
    Lens lens;
    double image_noise;

    Start start_of(const double* quad, const double* h, double word, double fit, double gap) const {
        Start start;
        std::copy_n(h, 9, start.h);
        const double cell = std::sqrt(std::fabs(area(quad))) / shape.cells;
        if (lens.distorted) {
            double ideal[8];
            for (int k = 0; k < 4; ++k) lens.to_ideal(quad[2 * k], quad[2 * k + 1], ideal + 2 * k, ideal + 2 * k + 1);
            from_square(ideal, 0.5 * shape.cells, start.h);
        }
        start.level = (cell > limit.next_level[0]) + (cell > limit.next_level[1]);
        const double blur = limit.start_blur * cell / std::pow(2.0, start.level);
        start.blur = std::max(1.0, blur * blur);
        start.word = word, start.fit = fit, start.gap = gap;
        return start;
    }

    void align(State& state, const std::vector<Start>& first) const {
        const int black = shape.cells * shape.cells;
        for (std::size_t m = 0; m < first.size(); ++m) {
            std::copy_n(first[m].h, 9, &state.h[9 * m]);
            state.blur[m] = first[m].blur, state.level[m] = first[m].level;
            std::copy_n(is.black_words + int(first[m].word) * black, black, &state.black[m * black]);
        }
        alvar_align(state.markers, atlas.greys, atlas.stride, atlas.width, atlas.height, table, lens_numbers, shape.cells,
                    shape.count, is.line, is.weight, is.normal_step, is.align_limits, int(limit.steps), 1u << 1,
                    state.black.data(), state.level.data(), state.h.data(), state.blur.data(), state.all.data(),
                    state.numbers.data(), state.normal.data());
    }

    // Adds the markers and what is unsure to `found`, and those whose reading differs from the drawing to `changed`, drawn
    // as they are read; without it, the coarse decoding is not asked. `origins`: what unsure ones are to start from.
    void judge(State& state, const std::vector<Start>& first, const std::vector<Start>& origins, Changed* changed,
               const double* sizes, Found& found) const {
        const int markers = state.markers;
        std::vector<double> noise(markers), seen(6 * markers);
        for (int m = 0; m < markers; ++m)
            noise[m] = std::min(state.noise(m), limit.sampled_noise * image_noise / std::pow(2.0, state.level[m]));
        alvar_features(markers, state.samples, state.of(0, 0), state.of(1, 0), state.of(2, 0), state.of(3, 0),
                       state.of(5, 0), is.share, *is.all_weight, noise.data(), shape.data, is.data, is.smooth_basis,
                       shape.cells, is.group, is.is_data, limit.max_noise_share, limit.bad_cell, seen.data());
        for (int m = 0; m < markers; ++m) {
            double corners[8], blur[3];
            Features f = {seen[m], seen[2 * markers + m], seen[markers + m], seen[3 * markers + m], seen[4 * markers + m],
                          seen[5 * markers + m], state.contrast(m), state.noise(m), state.blur[m], 0, 0};
            corners_at(&state.h[9 * m], 0.5 * shape.cells, corners);
            blur_in_cells(&state.h[9 * m], state.blur[m] * std::pow(4.0, state.level[m]), blur);
            const double mean_blur = std::sqrt((blur[0] + blur[1]) / 2);
            if (!(area(corners) > limit.min_area) || !(f.likeness > limit.min_likeness) || !(mean_blur < limit.max_blur))
                continue;
            std::int64_t word = first[m].word;
            f.fit = first[m].fit, f.gap = first[m].gap;
            if (!changed || !(f.fit > limit.sure_fit && f.gap > limit.sure_gap && f.likeness > limit.sure_fit))
                word = read(state, m, blur, noise[m], f);
            const Place place = {(corners[0] + corners[2] + corners[4] + corners[6]) / 4,
                                 (corners[1] + corners[3] + corners[5] + corners[7]) / 4, std::sqrt(area(corners))};
            const bool drawn = word == first[m].word;
            if (drawn && accepted(f, limit) && !has_other_margin(corners, f)) {
                if (add(state, m, word, corners, f, sizes, found.records)) found.places.push_back(place);
            } else if (may_be_covered(f, limit)) {
                found.unsure.push_back(origins[m]), found.unsure_places.push_back(place);
            } else if (!drawn && changed && f.fit > limit.changed_fit) {
                Start start;
                std::copy_n(&state.h[9 * m], 9, start.h);
                start.word = word, start.blur = state.blur[m], start.level = state.level[m];
                start.fit = start.gap = 0;
                changed->now.push_back(start), changed->before.push_back(origins[m]);
            }
        }
    }

    void to_real(const double* corners, double* real) const {
        if (!lens.distorted) {
            std::copy_n(corners, 8, real);
            return;
        }
        for (int k = 0; k < 4; ++k) lens.to_real(corners[2 * k], corners[2 * k + 1], real + 2 * k, real + 2 * k + 1);
    }

    // Reads the cells of an aligned marker; sets fit and gap, returns the word.
    std::int64_t read(State& state, int m, const double* blur, double noise, Features& f) const {
        const int side = shape.inside;
        std::vector<float> clipped(side * side);
        const float *values = state.of(0, m), *gain = state.of(3, m), *dark = state.of(4, m);
        for (int j = 0; j < side; ++j)
            for (int i = 0; i < side; ++i) {
                const int at = (shape.first_inside + j) * shape.count + shape.first_inside + i;
                const float spare = limit.contrast_spare * gain[at];
                clipped[j * side + i] = within(values[at], dark[at] - spare, dark[at] + gain[at] + spare);
            }
        double out[2];
        std::int64_t word = 0;
        alvar_read(1, side, clipped.data(), is.inside_line, kResolution, is.light, is.normal_step, blur, &noise, kAllWords,
                   is.words, limit.max_noise_share, out, &word);
        f.fit = out[0], f.gap = out[1];
        return word;
    }

    bool has_other_margin(const double* corners, const Features& f) const {
        if (f.detail > limit.sure_margin_detail) return false;
        double real[8], fits[3];
        to_real(corners, real);
        for (int k = 0; k < 3; ++k)
            fits[k] = alvar_coarse_fit(smooth.greys, smooth.stride, smooth.width, smooth.height, real, 0.5 * shape.cells,
                                       shape.cells / (shape.cells + 2.0 * (k - 1)), shape.coarse, is.cell_points,
                                       kAllWords, is.coarse_words);
        return std::max(fits[0], fits[2]) > fits[1];
    }

    // Measures a marker, and adds it if a pose fits its corners; returns whether one does.
    bool add(State& state, int m, std::int64_t word, double* corners, const Features& f, const double* sizes,
             std::vector<Record>& records) const {
        const int black = shape.cells * shape.cells;
        double information[64], turned[8];
        alvar_measure_corners(full.greys, full.stride, full.width, full.height, lens_numbers, 1, shape.cells,
                              &state.h[9 * m], &state.blur[m], &state.level[m], &state.numbers[state.markers + m], &f.kept,
                              &state.normal[225 * m], &state.black[m * black], is.scale, is.edge_limits, is.cell_limits,
                              is.corner_limits, corners, information);
        Record record;
        const int turns = word / kNumbers, number = word % kNumbers;
        record.number = number;
        const auto from = [&](int i) { return (2 * turns + i) % 8; };  // corner and axis in the order of the drawing
        for (int i = 0; i < 8; ++i) {
            turned[i] = corners[from(i)];
            for (int j = 0; j < 8; ++j) record.information[8 * i + j] = information[8 * from(i) + from(j)];
        }
        int poses = 0;
        alvar_poses(1, turned, sizes + number, lens_numbers, record.information, record.solutions[0], &poses);
        to_real(turned, record.corners);
        if (!poses || !(record.solutions[0][12] < limit.max_pose_error * std::sqrt(area(record.corners)))) return false;
        record.poses = poses, record.features = f;
        records.push_back(record);
        return true;
    }
};

template <typename Row>
int copy_rows(const std::vector<Row>& rows, int room, double* out) {
    const std::size_t some = std::min<std::size_t>(room, rows.size());
    if (some) std::memcpy(out, rows.data(), some * sizeof(Row));
    return rows.size();
}

}  // namespace

// Finds the markers among quads (count, 4, 2), whose sides are moved to where the grey rises. Writes, of each marker, a
// Record; of each candidate that needs a closer look, a Start; of each one that was well read, its quad (4, 2) and word;
// and the numbers of them and of the quads that have such sides, which are moved to the front (4,). There is room for `room` of each, which must be at least the largest number of candidates that are aligned.
extern "C" void alvar_find_in_even_light(const void* const* constants, const std::uint8_t* smooth,
                                         std::int64_t smooth_stride, int width, int height, const std::uint8_t* atlas,
                                         std::int64_t atlas_stride, int atlas_width, int atlas_height,
                                         const float* table, const double* lens, double noise, int count, double* quads,
                                         const double* sizes, int room, double* records, double* starts,
                                         double* well_read, int* found) {
    Constants all;
    std::memcpy(&all, constants, sizeof all);
    std::vector<Record> markers;
    std::vector<Start> unsure;
    std::vector<double> well;
    found[3] = Search(all, {smooth, smooth_stride, width, height}, {atlas, atlas_stride, atlas_width, atlas_height}, height, table,
                      lens, noise)
                   .run(count, quads, sizes, markers, unsure, well);
    found[0] = copy_rows(markers, room, records), found[1] = copy_rows(unsure, room, starts);
    found[2] = copy_rows(well, 9 * room, well_read) / 9;
}

// prepared_image.noise_of
extern "C" double alvar_noise(const std::uint8_t* greys, std::int64_t stride, int width, int height) {
    std::vector<std::int64_t> counts(4 * 255 + 1, 0);
    std::int64_t all = 0;
    for (int y = 4; y < height; y += std::max(1, height / 12)) {
        const std::uint8_t* row = greys + y * stride;
        for (int x = 1; x < width - 1; ++x) ++counts[std::abs(2 * row[x] - row[x - 1] - row[x + 1])];
        all += std::max(0, width - 2);
    }
    std::int64_t before = 0;
    std::size_t k = 0;
    while (k + 1 < counts.size() && 2 * (before + counts[k]) < all) before += counts[k++];
    const double middle = k ? k - 0.5 + (0.5 * all - before) / std::max<std::int64_t>(counts[k], 1) : 0.5;
    return middle / (0.6745 * std::sqrt(6.0));
}
