// acceptance.Appearance: the features of a candidate, and which thresholds it misses
#include "algebra.h"
#include "energy.h"
#include "steps.h"

namespace {

using namespace alvar;

constexpr int kSmooth = 6;  // functions that are removed from the data cells
constexpr int kStrips = 4;

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

// Whether the code of a candidate is one that dark things look like by chance
bool is_plain(const Features& f, const Thresholds& limit) { return f.edges <= limit.PLAIN_EDGES; }

double margin_ratio_of(const Features& f, const Thresholds& limit) {
    return f.score_gap / (limit.BEST_FIT - std::min(f.fit, 1.0));
}

const Requirement& requirement(const Features& f, const Thresholds& limit, const char* (&names)[3]) {
    struct Choice {
        const Requirement& requirement;
        const char* names[3];
    };
    const Choice choices[] = {
        {limit.CODE_COVERED, {"CODE_COVERED.fit", "CODE_COVERED.margin_ratio", "CODE_COVERED.correlation"}},
        {limit.COVERED, {"COVERED.fit", "COVERED.margin_ratio", "COVERED.correlation"}},
        {limit.CLEAR, {"CLEAR.fit", "CLEAR.margin_ratio", "CLEAR.correlation"}},
        {limit.UNLIKE, {"UNLIKE.fit", "UNLIKE.margin_ratio", "UNLIKE.correlation"}},
        {limit.PLAIN, {"PLAIN.fit", "PLAIN.margin_ratio", "PLAIN.correlation"}}};
    const int which = is_plain(f, limit)                                                 ? 4
                      : f.bad_inside >= limit.CODE_COVERED_CELLS && f.score_gap > limit.WIDE_SCORE_GAP ? 0
                      : f.bad_rim + 2 * f.bad_inside >= limit.COVERED_CELLS               ? 1
                      : f.likeness > limit.CLEAR_LIKENESS                                 ? 2
                                                                                          : 3;
    std::copy(choices[which].names, choices[which].names + 3, names);
    return choices[which].requirement;
}

// The first check that fails: each has a result, its threshold, the value and the value needed.
struct Check {
    bool holds;
    Shortfall shortfall;
};

template <std::size_t count>
Shortfall first_missed(const Check (&checks)[count]) {
    for (const Check& each : checks)
        if (!each.holds) return each.shortfall;
    return {nullptr, 0, 0};
}

Check above(const char* threshold, double value, double needed) {
    return {value > needed, {threshold, value, needed}};
}

Check at_most(const char* threshold, double value, double most) { return {value <= most, {threshold, value, most}}; }

}  // namespace

Features Appearance::features(const AlignedMarker& marker, double noise, const Thresholds& limit) const {
    const int groups = cells * cells + kStrips, samples = share.size(), data_count = data.size();
    const float *values = marker.values, *drawing = marker.drawing;
    std::vector<float> v(data_count), t(data_count);
    std::vector<double> mean(groups), size(groups);
    Features f = {};
    f.likeness = correlation(values, drawing, share.data(), samples, noise, limit.MAX_NOISE_SHARE);
    for (int i = 0; i < data_count; ++i) v[i] = values[data[i]], t[i] = drawing[data[i]];
    remove_part(v.data(), smooth.data(), data_count, kSmooth);
    remove_part(t.data(), smooth.data(), data_count, kSmooth);
    double vv = 0, tt = 0, vt = 0, inliers = 0;
    for (int i = 0; i < data_count; ++i)
        vv += double(v[i]) * v[i], tt += double(t[i]) * t[i], vt += double(v[i]) * t[i];
    f.correlation = vt / std::sqrt(without_noise(vv, data_count * noise * noise, limit.MAX_NOISE_SHARE) * tt + 1e-6);
    for (int i = 0; i < samples; ++i) {
        inliers += marker.weights[i];
        if (group[i] < 0) continue;
        mean[group[i]] += (values[i] - marker.model[i]) / marker.gain[i];
        size[group[i]] += 1;
    }
    for (int i = 0; i < cells * cells; ++i)
        if (std::fabs(mean[i] / size[i]) > limit.BAD_CELL) ++(is_data[i] ? f.bad_inside : f.bad_rim);
    double strips[kStrips];
    for (int i = 0; i < kStrips; ++i) strips[i] = mean[cells * cells + i] / size[cells * cells + i];
    std::sort(strips, strips + kStrips);
    f.outside = strips[0], f.outside_but_one = strips[1];
    f.inlier_share = inliers / weight;
    f.contrast = *marker.contrast, f.noise = *marker.noise, f.blur = *marker.blur;
    return f;
}

Shortfall alvar::unpromising(const double* h, double blur, std::int64_t level, double likeness, int cells,
                             const Thresholds& limit) {
    double corners[8], in_cells[3];
    corners_at(h, 0.5 * cells, corners);
    blur_in_cells(h, blur * std::pow(4.0, level), in_cells);
    const double mean_blur = std::sqrt((in_cells[0] + in_cells[1]) / 2);
    return first_missed({above("MIN_MARKER_AREA", area(corners), limit.MIN_MARKER_AREA),
                         above("MIN_LIKENESS", likeness, limit.MIN_LIKENESS),
                         {mean_blur < limit.MAX_BLUR, {"MAX_BLUR", mean_blur, limit.MAX_BLUR}}});
}

Shortfall alvar::shortfall(const Features& f, const Thresholds& limit) {
    const char* names[3];
    const Requirement& asked = requirement(f, limit, names);
    const double margin_ratio = margin_ratio_of(f, limit);
    if (is_sure(f, limit))
        // only the middle of bent paper agrees with the drawing; paper may end at one side, before something dark
        return first_missed({above("SURE_INLIER_SHARE", f.inlier_share, limit.SURE_INLIER_SHARE),
                             above("SURE_OUTSIDE", f.outside_but_one, limit.SURE_OUTSIDE)});
    return first_missed({above("MIN_SCORE_GAP", f.score_gap, limit.MIN_SCORE_GAP),
                         above("MIN_INLIER_SHARE", f.inlier_share, limit.MIN_INLIER_SHARE),
                         at_most("MAX_BAD_RIM", f.bad_rim, limit.MAX_BAD_RIM),
                         {f.outside > limit.MIN_OUTSIDE || f.likeness > limit.WHOLE_LIKENESS,
                          {"MIN_OUTSIDE", f.outside, limit.MIN_OUTSIDE}},
                         above(names[0], f.fit, asked.fit), above(names[1], margin_ratio, asked.margin_ratio),
                         above(names[2], f.correlation, asked.correlation)});
}

bool alvar::is_sure(const Features& f, const Thresholds& limit) {
    return !is_plain(f, limit) && f.fit > limit.SURE.fit && margin_ratio_of(f, limit) > limit.SURE.margin_ratio
           && f.correlation > limit.SURE.correlation;
}

bool alvar::may_be_covered(const Features& f, const Thresholds& limit) {
    return !is_plain(f, limit) && f.inlier_share > limit.MIN_INLIER_SHARE && f.bad_rim <= limit.MAX_BAD_RIM
           && f.bad_rim + f.bad_inside > 0 && f.outside > limit.MIN_OUTSIDE && f.fit > limit.CHANGED_FIT;
}
