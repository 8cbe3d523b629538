// The thresholds of detection/thresholds.py that compiled steps use, under the same names. module.cpp reads them there.
#pragma once

namespace alvar {

struct Range {
    double low, high;
};

struct Requirement {
    double fit, margin_ratio, correlation;
};

// clang-format off
#define ALVAR_NUMBERS(each) \
    each(MIN_OUTLINE_SIDE) each(MIN_FILLED) each(MAX_ASPECT) each(POLYGON_TOLERANCE) each(MAX_POLYGON_CORNERS) \
    each(SAME_QUAD) each(SAME_SIZE) each(SIDE_REACH) each(SIDE_NEARNESS) each(MIN_SIDE_RISE) each(SIDE_OUTLIERS) \
    each(MIN_RIM_CONTRAST) each(MIN_RIM_STEP) each(MIN_RIM_STEP_SHARE) each(MIN_DARK_RIM) each(MIN_COARSE_FIT) \
    each(COARSE_SCORE_GAP_WEIGHT) each(SMALL_CELL) each(SMALL_RISE) each(SMALL_RISE_SHARE) \
    each(SMALL_OFFSET) each(MAX_SMALL) each(SAMPLES_PER_CELL) each(START_BLUR) each(ALIGNMENT_STEPS) \
    each(STEPS_OF_ALL) each(SETTLED) each(MAX_STEP) each(FIRST_OUTLIER) each(OUTLIER) each(MIN_OUTLIER_NOISE) \
    each(MIN_OUTLIER_CONTRAST) each(MIN_START_GAIN) each(MAX_NOISE_SHARE) each(SAMPLED_NOISE) each(SURE_FIT) \
    each(SURE_SCORE_GAP) each(CONTRAST_SPARE) each(CHANGED_FIT) each(MIN_MARKER_AREA) each(MIN_LIKENESS) \
    each(MAX_BLUR) \
    each(CLEAR_LIKENESS) each(SURE_INLIER_SHARE) each(SURE_OUTSIDE) each(MIN_SCORE_GAP) each(WIDE_SCORE_GAP) \
    each(BEST_FIT) \
    each(BAD_CELL) each(COVERED_CELLS) each(CODE_COVERED_CELLS) each(MAX_BAD_RIM) each(PLAIN_EDGES) \
    each(MIN_INLIER_SHARE) \
    each(MIN_OUTSIDE) \
    each(WHOLE_LIKENESS) each(SURE_MARGIN_CORRELATION) each(OVERLAP) each(MAX_POSE_ERROR) each(MIN_EDGE_SIDE) \
    each(MAX_EDGE_MOVE) each(EDGE_REACH) each(EDGE_BLURS) each(MAX_EDGE_REACH) each(EDGE_START) each(MIN_EDGE_STEP) \
    each(MIN_EDGE_CONTRAST) each(EDGE_FITS) each(EDGE_OUTLIER) each(MIN_EDGE_OUTLIER) each(MIN_EDGE_NOISE) \
    each(MIN_EDGE_SEEN) each(CELL_STEPS) each(CELL_VARIANCE) each(MIN_PART) each(MIN_BROKEN_OUTLINE) \
    each(PART_TOLERANCE) each(PART_SIDE) each(DIRECTIONS) each(MAX_PARTS) each(MAX_CORNERS) each(MAX_BROKEN) \
    each(JOINED_GAP) each(JOINED_OFF) each(JOINED_TURN) each(CORNER_GAP) each(CORNER_SPARE) each(MIN_TURN) \
    each(MIN_OPPOSITE) each(MIN_BROKEN_SIDE) each(MIN_SHOWN) each(DARK_GREY) each(MIN_LOCAL_CONTRAST) \
    each(MIN_LOCAL_SHARE) each(MIN_LOCAL_STEP) each(MAX_PLAIN_CONTRAST) each(MAX_EDGE_COST) each(MIN_LOCAL_RIM) \
    each(LOCAL_REACH) each(MAX_LOCAL_REACH) each(EDGES_SETTLED) each(MIN_SEEN_EDGES) each(WELL_READ_FIT) \
    each(WELL_READ_SCORE_GAP) each(BOW_REACH) each(BOW_OVER_NOISE) each(BOW_OF_ONE) each(CORNER_MODEL_ERROR) \
    each(ALIGNED_ERROR) each(MISFIT_ERROR) each(COARSE_CORNER_ERROR) each(CORNER_NOISE_FACTOR) each(LIGHT_STEPS)
#define ALVAR_RANGES(each) each(SMALL_SIDE) each(NEXT_LEVEL) each(GAIN_LIMITS) each(BLUR_STEP_LIMITS) each(BLUR_LIMITS)
#define ALVAR_REQUIREMENTS(each) each(CLEAR) each(UNLIKE) each(COVERED) each(CODE_COVERED) each(SURE) each(PLAIN)
// clang-format on

struct Thresholds {
#define ALVAR_NUMBER(name) double name;
#define ALVAR_RANGE(name) Range name;
#define ALVAR_REQUIREMENT(name) Requirement name;
    ALVAR_NUMBERS(ALVAR_NUMBER)
    ALVAR_RANGES(ALVAR_RANGE)
    ALVAR_REQUIREMENTS(ALVAR_REQUIREMENT)
#undef ALVAR_NUMBER
#undef ALVAR_RANGE
#undef ALVAR_REQUIREMENT
};

}  // namespace alvar
