// search.Search: the search for markers of resolution 5 in even light, all steps on all candidates in one call.
//
// Candidates that need a closer look (covered cells) are only named: Detector._finish examines them.
#include <cmath>
#include <numeric>

#include "algebra.h"
#include "steps.h"

namespace {

using namespace alvar;

constexpr int kNumbers = 256;

struct Place {
    double x, y, side;
};

// A Start with the drawing of what was read, and the Start before it
struct Changed {
    std::vector<Start> now, before;
};

// The alignment of some markers, and the memory of its results
struct State {
    std::vector<double> numbers, normal;  // h, blur, contrast, noise, moved; normal equations
    std::vector<float> samples;
    std::vector<AlignedMarker> markers;

    State(const Search& search, const std::vector<Start>& starts)
        : numbers(13 * starts.size()), normal(kParameters * kParameters * starts.size()) {
        const int cells = search.aligner.cells, each = search.aligner.count * search.aligner.count;
        samples.resize(std::size_t(6) * each * starts.size());
        for (std::size_t m = 0; m < starts.size(); ++m) {
            const Start& start = starts[m];
            double* own = &numbers[13 * m];
            float* first = &samples[6 * each * m];
            std::copy_n(start.h[0], 9, own);
            own[9] = start.blur;
            markers.push_back({own, own + 9, start.level, &search.black_words[start.word * cells * cells], first,
                               first + each, first + 2 * each, first + 3 * each, first + 4 * each, first + 5 * each,
                               own + 10, own + 11, own + 12, &normal[kParameters * kParameters * m]});
        }
    }
};

class ImageSearch {
public:
    ImageSearch(const Search& search, const Image& smooth, const Measured& image, const Lens& lens, double noise,
                 const double* sizes, const Turn& turn, const Thresholds& limit, bool explain)
        : is(search), smooth(smooth), image(image), greys{image.pyramid.atlas.lit(nullptr), image.pyramid.levels},
          lens(lens), image_noise(noise), sizes(sizes), turn(turn), limit(limit), cells(search.aligner.cells),
          half(0.5 * search.aligner.cells),
          trail(explain ? &result.ended : nullptr) {}

    SearchResult run(std::vector<double> quads) {
        const int count = refine_sides(smooth, quads.size() / 8, quads.data(), limit, trail);
        quads.resize(8 * count);
        const CoarseMatch match = is.decoder.match(smooth, count, quads.data(), limit, trail);
        std::vector<double> dark(8 * match.kept.size()), rank;
        std::vector<int> near;
        for (std::size_t i = 0; i < match.kept.size(); ++i) {
            std::copy_n(&quads[8 * match.kept[i]], 8, &dark[8 * i]);
            rank.push_back(match.fit[i] + limit.COARSE_SCORE_GAP_WEIGHT * match.score_gap[i]);
            if (match.fit[i] > limit.MIN_COARSE_FIT) near.push_back(i);
            else end_at(trail, &dark[8 * i], {"MIN_COARSE_FIT", match.fit[i], limit.MIN_COARSE_FIT}, match.word[i]);
        }
        std::vector<int> chosen = distinct(dark.data(), rank.data(), near, limit);
        const std::vector<int> taken = in_turn(dark.data(), chosen, turn);
        result.left_out = chosen.size() - taken.size();
        for (std::size_t k = 0, next = 0; k < chosen.size(); ++k) {
            if (next < taken.size() && taken[next] == int(k)) ++next;
            else end_at(trail, &dark[8 * chosen[k]], {"max_candidates", double(chosen.size()), double(turn.most)},
                        match.word[chosen[k]]);
        }
        result.refined = std::move(quads);
        std::vector<Start> starts;
        for (const int place : taken) {
            const int i = chosen[place];
            starts.push_back(start_of(&dark[8 * i], match, i));
            if (match.fit[i] > limit.WELL_READ_FIT && match.score_gap[i] > limit.WELL_READ_SCORE_GAP) {
                WellRead well;
                std::copy_n(&dark[8 * i], 8, well.quad[0]);
                well.word = match.word[i];
                result.well_read.push_back(well);
            }
        }
        Changed changed;
        judge(starts, starts, &changed);
        judge(changed.now, changed.before, nullptr);
        for (std::size_t k = 0; k < unsure.size(); ++k)
            if (!is_known(unsure_places[k])) result.unsure.push_back(unsure[k]);
        return std::move(result);
    }

private:
    const Search& is;
    const Image& smooth;
    const Measured& image;
    const Pyramid greys;
    const Lens& lens;
    const double image_noise;
    const double* sizes;
    const Turn& turn;
    const Thresholds& limit;
    const int cells;
    const double half;
    SearchResult result;
    Trail* const trail;
    std::vector<Start> unsure;
    std::vector<Place> places, unsure_places;  // of the markers, of what is unsure

    bool is_known(const Place& at) const {
        return std::any_of(places.begin(), places.end(), [&](const Place& other) {
            return std::hypot(other.x - at.x, other.y - at.y) < limit.OVERLAP * at.side;
        });
    }

    Start start_of(const double* quad, const CoarseMatch& match, int i) const {
        Start start;
        std::copy_n(&match.h[9 * i], 9, start.h[0]);
        const double cell = std::sqrt(std::fabs(area(quad))) / cells;
        if (lens.distorted()) {
            double ideal[8];
            for (int k = 0; k < 4; ++k) lens.to_ideal(quad[2 * k], quad[2 * k + 1], ideal + 2 * k, ideal + 2 * k + 1);
            from_square(ideal, half, start.h[0]);
        }
        start.level = (cell > limit.NEXT_LEVEL.low) + (cell > limit.NEXT_LEVEL.high);
        const double blur = limit.START_BLUR * cell / std::pow(2.0, start.level);
        start.blur = std::max(1.0, blur * blur);
        start.word = match.word[i], start.fit = match.fit[i], start.score_gap = match.score_gap[i];
        return start;
    }

    // Aligns and judges; adds the markers and the unsure candidates. Those that were read as something else than was
    // drawn are added to `changed`, with the new drawing; without `changed`, the coarse decoding is not used.
    // `origins`: the Starts of the unsure ones.
    void judge(const std::vector<Start>& starts, const std::vector<Start>& origins, Changed* changed) {
        if (starts.empty()) return;
        State state(is, starts);
        is.aligner.run(greys, lens, state.markers, int(limit.ALIGNMENT_STEPS), 1u << 1, limit);
        for (std::size_t m = 0; m < starts.size(); ++m) {
            const AlignedMarker& marker = state.markers[m];
            const double sampled = limit.SAMPLED_NOISE * image_noise / std::pow(2.0, marker.level);
            const double noise = std::min(*marker.noise, sampled);
            Features f = is.appearance.features(marker, noise, limit);
            double corners[8];
            corners_at(marker.h, half, corners);
            std::int64_t word = starts[m].word;
            Shortfall missed = unpromising(marker.h, *marker.blur, marker.level, f.likeness, cells, limit);
            if (missed.threshold) {
                end(corners, missed, word);
                continue;
            }
            f.fit = starts[m].fit, f.score_gap = starts[m].score_gap;
            if (!changed || !(f.fit > limit.SURE_FIT && f.score_gap > limit.SURE_SCORE_GAP
                              && f.likeness > limit.SURE_FIT))
                word = read(marker, noise, f);
            f.edges = is.edges[word];
            const Place place = {(corners[0] + corners[2] + corners[4] + corners[6]) / 4,
                                 (corners[1] + corners[3] + corners[5] + corners[7]) / 4, std::sqrt(area(corners))};
            const bool drawn = word == starts[m].word;
            missed = drawn                       ? shortfall(f, limit)
                     : f.fit > limit.CHANGED_FIT ? Shortfall{"SAME_WORD", 0, 0}
                                                   : Shortfall{"CHANGED_FIT", f.fit, limit.CHANGED_FIT};
            if (drawn && !missed.threshold) missed = other_margin(corners, f);
            if (!missed.threshold) {
                missed = add(marker, word, corners, f);
                if (!missed.threshold) places.push_back(place);
                else end(corners, missed, word);
            } else if (may_be_covered(f, limit)) {
                unsure.push_back(origins[m]), unsure_places.push_back(place);
            } else if (!drawn && changed && f.fit > limit.CHANGED_FIT) {
                Start start = {};
                std::copy_n(marker.h, 9, start.h[0]);
                start.word = word, start.blur = *marker.blur, start.level = marker.level;
                changed->now.push_back(start), changed->before.push_back(origins[m]);
            } else {
                end(corners, missed, word);
            }
        }
    }

    void to_real(const double* corners, double* real) const {
        std::copy_n(corners, 8, real);
        if (lens.distorted())
            for (int k = 0; k < 4; ++k) lens.to_real(corners[2 * k], corners[2 * k + 1], real + 2 * k, real + 2 * k + 1);
    }

    // Reads the cells of an aligned marker; sets fit and score gap, returns the word.
    std::int64_t read(const AlignedMarker& marker, double noise, Features& f) const {
        const int count = is.aligner.count, side = is.reader.side, first = (count - side) / 2;
        std::vector<float> clipped(side * side);
        double blur[3];
        blur_in_cells(marker.h, *marker.blur * std::pow(4.0, marker.level), blur);
        for (int j = 0; j < side; ++j)
            for (int i = 0; i < side; ++i) {
                const int at = (first + j) * count + first + i;
                const float gain = marker.gain[at], dark = marker.dark[at], spare = limit.CONTRAST_SPARE * gain;
                clipped[j * side + i] = within(marker.values[at], dark - spare, dark + gain + spare);
            }
        const Reader::Read found = is.reader.read(clipped.data(), blur[0], blur[1], noise, limit);
        f.fit = found.fit, f.score_gap = found.score_gap;
        return found.word;
    }

    Shortfall other_margin(const double* corners, const Features& f) const {
        if (f.correlation > limit.SURE_MARGIN_CORRELATION) return {nullptr, 0, 0};
        double real[8];
        to_real(corners, real);
        return is.decoder.other_margin(smooth, real);
    }

    void end(const double* corners, const Shortfall& missed, std::int64_t word) const {
        if (!trail) return;
        double real[8];
        to_real(corners, real);
        end_at(trail, real, missed, word);
    }

    // Measures a marker, and adds it if a pose fits its corners, or if its code is clear; returns the threshold that
    // the pose misses.
    Shortfall add(const AlignedMarker& aligned, std::int64_t word, double* corners, const Features& f) {
        double information[64], turned[8];
        FoundMarker marker = {};
        measure_corners(image, lens, is.aligner, aligned, f.inlier_share, is.scale.data(), limit, corners, information,
                        &marker.evidence);
        const int turns = word / kNumbers, number = word % kNumbers;
        const auto from = [&](int i) { return (2 * turns + i) % 8; };  // corner and axis in the order of the drawing
        for (int i = 0; i < 8; ++i) {
            turned[i] = corners[from(i)];
            for (int j = 0; j < 8; ++j) marker.information[i][j] = information[8 * from(i) + from(j)];
        }
        marker.number = number, marker.features = f;
        marker.poses = solve_pose(turned, sizes[number], lens, marker.information[0], marker.solutions);
        to_real(turned, marker.corners[0]);
        const double side = std::sqrt(area(marker.corners[0]));
        if (!marker.poses) return {"MAX_POSE_ERROR", HUGE_VAL, limit.MAX_POSE_ERROR};
        if (!(marker.solutions[0].error < limit.MAX_POSE_ERROR * side) && !is_sure(f, limit))
            return {"MAX_POSE_ERROR", marker.solutions[0].error / side, limit.MAX_POSE_ERROR};
        result.markers.push_back(marker);
        return {nullptr, 0, 0};
    }
};

}  // namespace

SearchResult Search::find(const Image& smooth, const Measured& image, const Lens& lens, double noise,
                          std::vector<double> quads, const double* sizes, const Turn& turn,
                          const Thresholds& limit, bool explain) const {
    return ImageSearch(*this, smooth, image, lens, noise, sizes, turn, limit, explain).run(std::move(quads));
}
