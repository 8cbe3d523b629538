// search.Search: the search for markers of resolution 5 in even light, all steps on all candidates in one call.
//
// Candidates that need a closer look (covered cells) are only named: Detector._finish examines them.
#include <cmath>
#include <numeric>

#include "algebra.h"
#include "steps.h"

namespace {

using namespace alvar;

constexpr int kNumbers = 256, kTogether = 8;  // candidates that are examined at a time

struct Place {
    double x, y, side;

    // Whether the middle of another one is nearer than `reach`
    bool is_near(const Place& other, double reach) const {
        return (x - other.x) * (x - other.x) + (y - other.y) * (y - other.y) < reach * reach;
    }
};

Place place_of(const double* q) {
    return {(q[0] + q[2] + q[4] + q[6]) / 4, (q[1] + q[3] + q[5] + q[7]) / 4, std::sqrt(std::fabs(area(q)))};
}

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

    SearchResult run(const std::vector<double>& quads) {
        std::vector<double> dark, rank;
        std::vector<int> near;
        CoarseMatch match;
        std::vector<Place> sure;  // squares whose code is sure: what lies on them is not looked at
        for (std::size_t first = 0; first < quads.size(); first += 8 * kTogether) {
            std::vector<double> some;
            for (const double* q = &quads[first]; q < quads.data() + std::min(first + 8 * kTogether, quads.size()); q += 8)
                if (!lies_on(sure, place_of(q))) some.insert(some.end(), q, q + 8);
            const int count = refine_sides(smooth, some.size() / 8, some.data(), limit, trail);
            const CoarseMatch part = is.decoder.match(smooth, count, some.data(), limit, trail);
            result.refined.insert(result.refined.end(), some.begin(), some.begin() + 8 * count);
            for (std::size_t k = 0; k < part.kept.size(); ++k) {
                const double *quad = &some[8 * part.kept[k]], fit = part.fit[k], score_gap = part.score_gap[k];
                if (!(fit > limit.MIN_COARSE_FIT)) {
                    end_at(trail, quad, {"MIN_COARSE_FIT", fit, limit.MIN_COARSE_FIT}, part.word[k]);
                    continue;
                }
                if (fit > limit.SURE_FIT && score_gap > limit.SURE_SCORE_GAP) sure.push_back(place_of(quad));
                near.push_back(near.size());
                dark.insert(dark.end(), quad, quad + 8);
                rank.push_back(fit + limit.COARSE_SCORE_GAP_WEIGHT * score_gap);
                match.h.insert(match.h.end(), &part.h[9 * k], &part.h[9 * k] + 9);
                match.word.push_back(part.word[k]), match.fit.push_back(fit), match.score_gap.push_back(score_gap);
            }
        }
        std::vector<int> chosen = distinct(dark.data(), rank.data(), near, limit);
        const std::vector<int> taken = in_turn(dark.data(), chosen, turn);
        result.left_out = chosen.size() - taken.size();
        for (std::size_t k = 0, next = 0; k < chosen.size(); ++k) {
            if (next < taken.size() && taken[next] == int(k)) ++next;
            else end_at(trail, &dark[8 * chosen[k]], {"max_candidates", double(chosen.size()), double(turn.most)},
                        match.word[chosen[k]]);
        }
        std::vector<Start> starts;
        for (const int place : taken) {
            const int i = chosen[place];
            starts.push_back(start_of(&dark[8 * i], match, i));
        }
        Changed changed;
        judge(starts, starts, &changed);
        judge(changed.now, changed.before, nullptr);
        for (std::size_t k = 0; k < unsure.size(); ++k)
            if (!is_known(places, unsure_places[k])) result.unsure.push_back(unsure[k]);
        std::vector<Place> markers;  // in the image, as the quads are
        for (const FoundMarker& each : result.markers) markers.push_back(place_of(each.corners[0]));
        for (const int place : taken) {
            const int i = chosen[place];
            if (!(match.fit[i] > limit.WELL_READ_FIT && match.score_gap[i] > limit.WELL_READ_SCORE_GAP)
                || is_known(markers, place_of(&dark[8 * i])))
                continue;
            WellRead well;
            std::copy_n(&dark[8 * i], 8, well.quad[0]);
            well.word = match.word[i];
            result.well_read.push_back(well);
        }
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

    bool lies_on(const std::vector<Place>& squares, const Place& at) const {
        return std::any_of(squares.begin(), squares.end(), [&](const Place& square) {
            return at.side < limit.SAME_SIZE * square.side && at.is_near(square, limit.OVERLAP * square.side);
        });
    }

    bool is_known(const std::vector<Place>& markers, const Place& at) const {
        return std::any_of(markers.begin(), markers.end(), [&](const Place& other) {
            return at.is_near(other, limit.OVERLAP * at.side);
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

    // Judges some at a time, so that memory stays small, but not what lies on a marker that has been found. `origins`:
    // the Starts of the unsure ones.
    void judge(const std::vector<Start>& starts, const std::vector<Start>& origins, Changed* changed) {
        for (std::size_t first = 0; first < starts.size(); first += kTogether) {
            std::vector<Start> some, own_origins;
            for (std::size_t m = first; m < std::min(first + kTogether, starts.size()); ++m) {
                double corners[8];
                corners_at(starts[m].h[0], half, corners);
                if (lies_on(places, place_of(corners))) continue;
                some.push_back(starts[m]), own_origins.push_back(origins[m]);
            }
            judge_some(some, own_origins, changed);
        }
    }

    // Aligns and judges; adds the markers and the unsure candidates. Those that were read as something else than was
    // drawn are added to `changed`, with the new drawing; without `changed`, the coarse decoding is not used.
    void judge_some(const std::vector<Start>& starts, const std::vector<Start>& origins, Changed* changed) {
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
            const Place place = place_of(corners);
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
                          const std::vector<double>& quads, const double* sizes, const Turn& turn,
                          const Thresholds& limit, bool explain) const {
    return ImageSearch(*this, smooth, image, lens, noise, sizes, turn, limit, explain).run(quads);
}
