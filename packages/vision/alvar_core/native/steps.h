// The steps of the detector. Each has the name and the arrays of the Python class or function that calls it, whose
// docstring explains the numbers. Corners and places are x, y one after the other; matrices are row by row.
#pragma once
#include <cstdint>
#include <vector>

#include "image.h"
#include "thresholds.h"

namespace alvar {

constexpr int kParameters = 15;  // of an alignment: alignment.py
constexpr int kMostCells = 64;   // of a side: code.py allows fewer
// tanh(a z + b z^3 + c z^5) is 2 F(z) - 1 for the normal distribution F, to within 4e-5 (the form is that of Page, 1977)
constexpr float kNormalStep[3] = {0.7977178f, 0.03679826f, -0.000315808f};

// prepared_image.noise_of
double noise_of(const Image& grey);

// Half of an image (height / 2, width / 2), each grey that of the mean light of four
void halve(const Image& grey, const Light& light, std::uint8_t* out, std::int64_t stride);

// candidates.outlines: quads (N, 4, 2) around the outlines of pixels darker than the mean by `offset`, and the straight
// parts (K, 2, 2) of all outlines, if `parted`.
struct Outlines {
    std::vector<double> quads, parts;
};
Outlines outlines_of(const Image& smooth, const Image& mean, int offset, double shrink, bool parted,
                     const Thresholds& limit);

// candidates.small_squares: quads (N, 4, 2) of finer outlines, around those of the quads (count, 4, 2) that are small
std::vector<double> small_squares(const Image& smooth, int count, const double* quads, const Thresholds& limit);

// The first threshold that a candidate misses, its value and the one that it needs; `threshold` is null if there is none.
struct Shortfall {
    const char* threshold;
    double value, needed;
};

// Where the search for a candidate ended: its corners (4, 2) [real px], the threshold it missed, and the code word it
// resembles, or -1. Functions add to a Trail only if they get one.
struct Ended {
    double quad[8];
    Shortfall missed;
    std::int64_t word;
};
using Trail = std::vector<Ended>;
inline void end_at(Trail* trail, const double* quad, const Shortfall& missed, std::int64_t word = -1) {
    if (!trail) return;
    Ended ended = {{}, missed, word};
    for (int k = 0; k < 8; ++k) ended.quad[k] = quad[k];
    trail->push_back(ended);
}

// candidates.refined: changes quads (count, 4, 2) in place, moves those that are kept to the front; returns how many are.
int refine_sides(const Image& smooth, int count, double* quads, const Thresholds& limit, Trail* trail);

// candidates.distinct: those of `which` whose corners are not near those of one with a higher score, best first
std::vector<int> distinct(const double* quads, const double* score, std::vector<int> which, const Thresholds& limit);

// candidates.in_turn: of more than `most` quads, those whose turn it is, as places in `which`
struct Turn {
    std::int64_t most, first;
};
std::vector<int> in_turn(const double* quads, const std::vector<int>& which, const Turn& turn);

// uneven_light.free_of: which points (count, 2) lie in none of the squares (x, y, reach)
std::vector<std::uint8_t> free_of(const std::vector<double>& squares, int count, const double* points);

// broken_outlines.distinct_parts: moves parts (count, 2, 2) that are dark on their right to the front; returns how many.
int distinct_parts(const Image& smooth, int count, double* parts, const Thresholds& limit);

// broken_outlines.squares: quads (N, 4, 2), those with most of their rim first
std::vector<double> squares(int count, const double* parts, const Thresholds& limit);

// reading.CoarseMatch
struct CoarseMatch {
    std::vector<std::int64_t> kept, word;
    std::vector<double> h, fit, score_gap;
};

// reading.CoarseDecoder: `rim` (3, 40) and `cells` (3, P) are homogeneous points, `words` (P, W); `blurred`: the words
// of small markers (P, W), or empty; `known` (1 or W, P)
struct CoarseDecoder {
    double half;
    int points, all_words;
    std::vector<float> rim, cells, words, blurred, known;

    CoarseMatch match(const Image& smooth, int count, const double* quads, const Thresholds& limit, Trail* trail) const;
    // NARROWER_MARGIN or WIDER_MARGIN with the fit of its word and the higher one with that margin
    Shortfall other_margin(const Image& smooth, const double* real_corners) const;

private:
    void match_words(const Image& smooth, const std::vector<int>& places, const std::vector<float>& drawn,
                     CoarseMatch& found) const;
    double fit(const Image& smooth, const double* quad, double spread) const;
    void scale(const float* grey, float* of_words) const;
};

// How much each of `count` places [cells] of a line is covered by each of `cells` cells around its origin, with a blur:
// out (count, cells)
void coverage(const float* line, int count, int cells, double variance, float* out);

// reading.Reader for markers of resolution 5: `line` (S,) [cells], `light` (S^2, 4), `words` (25, W)
struct Reader {
    int side, all_words;
    std::vector<float> line, light, words;

    struct Read {
        std::int64_t word;
        double fit, score_gap;
    };
    // values (S, S) [greys]; xx, yy [cells^2]: of the blur
    Read read(const float* values, double xx, double yy, double noise, const Thresholds& limit) const;
};

// The state of the alignment of one marker: fields of alignment.Alignment
struct AlignedMarker {
    double *h, *blur;
    std::int64_t level;
    const std::uint8_t* black;  // (cells, cells)
    float *values, *drawing, *model, *gain, *dark, *weights;  // (count^2,)
    double *contrast, *noise, *moved, *normal;
};

// alignment.Aligner: `line` (count,) [cells], `weight` (count^2,)
struct Aligner {
    int cells, count;
    std::vector<float> line, weight;

    // `redraw`: a bit for each step before which the drawing is computed again
    void run(const Pyramid& pyramid, const Lens& lens, std::vector<AlignedMarker>& markers, int steps, unsigned redraw,
             const Thresholds& limit) const;
    // The greys (count^2,) at the samples of a marker
    void sample(const Pyramid& pyramid, const Lens& lens, const double* h, std::int64_t level, float* values) const;
};

// acceptance.Features
struct Features {
    double likeness, outside, correlation;
    std::int64_t bad_inside, bad_rim;
    double inlier_share, contrast, noise, blur, fit, score_gap;
    std::int64_t edges;
    double outside_but_one;
};

// acceptance.Appearance: `share` (P,), `weight`: sum of the weights; `data` (D,): samples of the data cells; `smooth`
// (D, 6); `group` (P,): the cell that a sample is in, cells^2 and more for the strips around the marker, or -1;
// `is_data` (cells^2,)
struct Appearance {
    int cells;
    double weight;
    std::vector<float> share, smooth;
    std::vector<std::int64_t> data;
    std::vector<std::int32_t> group;
    std::vector<std::uint8_t> is_data;

    // The Features that need no reading: all but fit, score gap and edges
    Features features(const AlignedMarker& marker, double noise, const Thresholds& limit) const;
};

// The first threshold that a candidate misses; none for a marker
Shortfall shortfall(const Features& f, const Thresholds& limit);
bool may_be_covered(const Features& f, const Thresholds& limit);
// Whether its code is too clear to be chance
bool is_sure(const Features& f, const Thresholds& limit);
// The first threshold that an aligned candidate misses before its cells are read
Shortfall unpromising(const double* h, double blur, std::int64_t level, double likeness, int cells,
                      const Thresholds& limit);

// edge_alignment.EdgePoints, the places one after the other: `x`, `y` [cells], direction from black to white
struct EdgePoints {
    std::vector<double> x, y, right, down;
};
EdgePoints edge_points(const std::uint8_t* black, int cells, const std::vector<double>& places);

// A marker's measurement of the logarithm of the exponent of Light: information, and information times the change
struct ResponseEvidence {
    double information, weighted;
};

// edge_alignment.EdgeFit
struct EdgeFit {
    bool seen_enough;
    double parameters[9], covariance[81], error, cost;
    std::vector<std::uint8_t> agrees;
};
// `asked`: the Light that `grey` is read with; if it is given, the evidence is set
EdgeFit fit_edges(const Image& grey, const Lens& lens, const double* h, const EdgePoints& points, const double* scale,
                  double reach, double first_reach, int steps, const Thresholds& limit,
                  const Light* asked = nullptr, ResponseEvidence* evidence = nullptr);
// bent_paper.fit_curved of a marker with `cells` cells per side, from `theta` (parameters,), of which the first `free` move
EdgeFit fit_curved(const Image& grey, const Lens& lens, int cells, const double* theta, int parameters, int free,
                   const EdgePoints& points, const double* scale, double reach, double first_reach, int steps,
                   const Thresholds& limit);

// refine_edges: corners (4, 2) and their covariance (8, 8); whether all sides are visible
bool refine_edges(const Image& grey, const Lens& lens, const double* h, double half, double sigma,
                  const Thresholds& limit, double* corners, double* covariance);
// corners.CornerEstimator.bow [px], of a marker with corners (4, 2)
double bow(const Image& grey, const Lens& lens, const double* corners, int cells, const Thresholds& limit);

// The images in which markers are measured: `pyramid` and `full` are read as light; `asked`: the Light, if markers
// are to give evidence about it, else null.
struct Measured {
    Pyramid pyramid;
    Image full;
    const Light* asked;
};
// corners.CornerEstimator.measure: changes corners (4, 2), sets their information (8, 8), which is 0 if a matrix is
// singular. `scale` (8,): edge_alignment.scale_of
void measure_corners(const Measured& image, const Lens& lens, const Aligner& aligner, const AlignedMarker& aligned,
                     double inlier_share, const double* scale, const Thresholds& limit, double* corners,
                     double* information, ResponseEvidence* evidence);

// pose.Solution
struct Solution {
    double rotation[3][3], position[3], error, chi2;
};
// pose.solve for a square with corners (4, 2) [ideal px]: up to two Solutions, best first; returns how many.
int solve_pose(const double* corners, double size, const Lens& lens, const double* information, Solution* solutions);

// local_contrast.LocalMatch of one marker
struct LocalMatch {
    double rim, contrast, plain, fit, score_gap;
    std::int64_t word;
};

// local_contrast.LocalDecoder: `rim` and `points` are homogeneous points (3, 2 * pairs), three pairs for each edge;
// `of_code` (edges,): which edges are those of the code; `costs` (3 * those, W): 1 where it counts
struct LocalDecoder {
    int edges, all_words;
    std::vector<float> rim, points;
    std::vector<std::uint8_t> of_code, costs;

    LocalMatch match(const Image& smooth, const double* h, const Thresholds& limit) const;
    // The share of the rim that is an edge, and its typical contrast; both 0 if the share is below MIN_LOCAL_RIM
    void rim_of(const Image& smooth, const double* h, const Thresholds& limit, double* share, double* contrast) const;
};
// local_contrast.LocalDecoder.contrasts of one marker: seen (pairs,)
void contrasts(const Image& smooth, const double* h, const float* points, int pairs, const Thresholds& limit,
               float* seen);

// A marker that the search has found: its number, corners (4, 2) [real px] as drawn, their information (8, 8)
struct FoundMarker {
    std::int64_t number;
    double corners[4][2], information[8][8];
    std::int64_t poses;
    Solution solutions[2];
    Features features;
    ResponseEvidence evidence;
};

// A candidate that needs a closer look: where its alignment starts, and its coarse decoding
struct Start {
    double h[3][3], blur;
    std::int64_t level, word;
    double fit, score_gap;
};

// A candidate whose cells were well read
struct WellRead {
    double quad[4][2];
    std::int64_t word;
};

struct SearchResult {
    std::vector<FoundMarker> markers;
    std::vector<Start> unsure;
    std::vector<WellRead> well_read;
    std::vector<double> refined;  // quads (N, 4, 2)
    std::int64_t left_out;        // candidates whose turn it is not
    Trail ended;                  // only if it is asked for
};

// search.Search: finds markers of resolution 5 whose greys fit their drawing. `black_words` (W, cells, cells)
struct Search {
    const CoarseDecoder& decoder;
    const Aligner& aligner;
    const Appearance& appearance;
    const Reader& reader;
    std::vector<double> scale;  // of edges: edge_alignment.scale_of
    std::vector<std::uint8_t> black_words;
    std::vector<std::int64_t> edges;  // (W,): acceptance.edges

    // `sizes` (256,) [m]: of the marker with each number
    SearchResult find(const Image& smooth, const Measured& image, const Lens& lens, double noise,
                      const std::vector<double>& quads, const double* sizes, const Turn& turn, const Thresholds& limit,
                      bool explain) const;
};

}  // namespace alvar
