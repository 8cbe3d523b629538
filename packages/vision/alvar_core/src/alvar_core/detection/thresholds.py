"""All numbers that decide what the detector finds, grouped by the stage that uses them.

They are measured, not derived: with these values ``./run bench markers FRAMES`` reaches its goals for recall, pose
errors, false detections, wrong ids and flips. docs/marker_thresholds.md shows what -10 % and +10 % of a number (whole
ones by at least 1) did to release 0.2.0; "Sensitivity" at each group below is its summary: recall in markers, 95th
percentile of the rotation error in degrees. Nothing gave a false detection, a wrong id or an unflagged flip.

A number without any effect there limits cost, or guards against input that is rarer than those scenes.
Lengths are shares of the marker's side, cells or pixels, as stated; greys run from 0 to 255.
"""
import math
from typing import NamedTuple


class Pass(NamedTuple):
    """One search for dark outlines: the image is reduced, then compared with its local mean.

    ``shrink``: factor; ``window`` [px of the reduced image], odd: width of the local mean; ``offset`` [greys]: how much
    darker than that mean a pixel must be.
    """

    shrink: float
    window: int
    offset: int


class Requirement(NamedTuple):
    """The lowest values of a candidate that is accepted; noise is subtracted from all of them.

    ``fit``: of the data cells to the code word; ``margin_ratio``: score gap to the next best word as a share of what
    the best one leaves unexplained; ``correlation``: of the cells with the drawing, after smooth changes of brightness
    are removed.
    """

    fit: float
    margin_ratio: float
    correlation: float


# -- Candidate outlines (candidates.py)
# Sensitivity: one marker more or less of medium (1.2 %) and hard (1.1 %), at most two of 7x7; rotation of hard +0.2.
PASSES = (
    Pass(1.5, 9, 3),  # small and faint markers
    Pass(2, 21, 15),  # markers that something thin touches
    Pass(4, 9, 4),  # large and faint markers in noise
)
MIN_OUTLINE_SIDE = 4  # px of the shrunk image
MIN_FILLED = 0.12  # share of the outline's box that the outline encloses
MAX_ASPECT = 6.0  # longest to shortest side
POLYGON_TOLERANCE = 0.03  # of the box's width and height: how far the polygon may be off the outline
MAX_POLYGON_CORNERS = 9
SAME_QUAD = 0.25  # of the side: quads with corners nearer than this are one

# -- Small squares, whose outlines are searched again in twice the resolution (candidates.small_squares)
# Sensitivity, on markers of 10 to 20 px: a higher SMALL_OFFSET loses one of 48.
SMALL_SIDE = 6.0, 17.0  # px, of an outline
SMALL_RISE, SMALL_RISE_SHARE = 20.0, 0.4  # greys, of the largest: brighter around, in all directions but one
SMALL_OFFSET = 0.08  # of the contrast there: how much darker than its surroundings a pixel must be
MAX_SMALL = 8  # in one image, those with the highest contrast

# -- Sides of a candidate, moved to where the grey rises (candidates.refined)
# Sensitivity: one hard marker less; rotation of hard up to -0.3.
SIDE_REACH = 0.16  # of the side, searched to each side of it
SIDE_NEARNESS = 0.4  # how much less a rise counts at the end of the reach
MIN_SIDE_RISE = 3.0  # greys, on half of each of three sides
SIDE_OUTLIERS = 4  # a point counts a quarter at 1 / this share of the reach off the line

# -- Coarse decoding (reading.CoarseDecoder)
# Sensitivity: a higher MIN_COARSE_FIT loses one hard marker, a lower SMALL_BLUR two of 48 small ones; the others change
# nothing.
MIN_RIM_CONTRAST = 5.0  # greys, of three sides
MIN_RIM_STEP, MIN_RIM_STEP_SHARE = 2.0, 0.35  # greys, of the contrast: a place on the rim is dark if the step is larger
MIN_DARK_RIM = 0.7  # share of the places on the rim
MIN_COARSE_FIT = 0.64  # with the best code word: worth an alignment
SMALL_CELL, SMALL_BLUR = 1.7, 0.8  # px of a cell: smaller ones are matched with words blurred by so many cells
COARSE_SCORE_GAP_WEIGHT = 0.5  # of the score gap beside the fit, to rank candidates
MAX_CANDIDATES = 400  # worth an alignment in one image, by default; rooms full of things, but markers, have up to 10

# -- Alignment with the drawn marker (alignment.py)
# Sensitivity: one marker less of hard and 7x7; rotation up to +1.1 (SAMPLES_PER_CELL). Limits change nothing.
SAMPLES_PER_CELL = 3
NEXT_LEVEL = (4 * math.sqrt(2), 8 * math.sqrt(2))  # px of a cell: larger ones are read at half, at quarter size
RIM_CELLS, RIM_SHARE = 1.6, 0.8  # cells, share of the margin: the outer part that is aligned before the id is known
START_BLUR, RIM_START_BLUR = 0.12, 0.3  # cells
ALIGNMENT_STEPS, RIM_ALIGNMENT_STEPS = 5, 8
STEPS_OF_ALL = 2  # steps that every candidate gets; further ones only if it has not settled
SETTLED = 0.1  # cells: the largest move of a corner by any one parameter
MAX_STEP = 0.6  # of each parameter of the homography in one step
FIRST_OUTLIER, OUTLIER = 4.0, 3.0  # noise: samples further off do not count; in the first step, later
MIN_OUTLIER_NOISE, MIN_OUTLIER_CONTRAST = 0.05, 4.0  # of the contrast, greys: noise is never taken for less
MIN_START_GAIN = 2.0  # greys
GAIN_LIMITS = (0.3, 2.0)  # of the mean contrast, anywhere on the marker
BLUR_STEP_LIMITS = (-0.5, 0.8)  # relative change in one step
BLUR_LIMITS = (0.25, 6.0)  # px^2 at the level

# -- Reading the aligned cells (reading.Reader)
# Sensitivity: a lower SAMPLED_NOISE loses one hard marker.
MAX_NOISE_SHARE = 0.3  # of the energy: noise is never taken for more
SAMPLED_NOISE = 2 / 3  # of the image's noise that is left in values between its pixels
SURE_FIT, SURE_SCORE_GAP = 0.93, 0.12  # of the coarse decoding: it is not read again, nor anything on that square
CONTRAST_SPARE = 0.25  # of the contrast: greys further beyond black and white are no noise but something else
CHANGED_FIT = 0.72  # a reading that differs from the drawing: worth another alignment
MIN_WHITE = 4.0  # greys: contrast of cells read one by one
CELL_RIDGE = 0.02  # of the mean diagonal, of the equations for cells read one by one

# -- Acceptance (acceptance.py, detector.py)
# Sensitivity: 10 % lower gains no marker and adds no false one; 10 % higher loses markers where fit, margin ratio and
# correlation are asked: UNLIKE.fit 2 of 95 hard ones, CLEAR.fit 1. BEST_FIT is the end of a scale, not to be tuned:
# below 1 nearly nothing is accepted.
MIN_MARKER_AREA = 80.0  # px^2
MIN_LIKENESS = 0.65  # correlation of the image with the drawn marker
MAX_BLUR = 1.1  # cells
CLEAR, UNLIKE = Requirement(0.87, 0.55, 0.83), Requirement(0.86, 0.85, 0.86)  # likeness above CLEAR_LIKENESS, below it
# Cells differ: any; data cells, with WIDE_SCORE_GAP
COVERED, CODE_COVERED = Requirement(0.86, 0.9, 0.78), Requirement(0.86, 0.7, 0.78)
CLEAR_LIKENESS = 0.88
SURE = Requirement(0.92, 1.5, 0.92)  # cannot be chance: the surroundings of the code may be worse, ...
# Codes with few edges between black and white cells resemble dark things with something bright in them, as windows are:
# 255 has 16 edges, 246 and 249 have 18, 240 and 244 have 20; half of all numbers have more than 30.
PLAIN_EDGES, PLAIN = 20, Requirement(0.94, 1.2, 0.93)  # at most; PLAIN then applies at any likeness
SURE_INLIER_SHARE, SURE_OUTSIDE = 0.6, -0.5  # ... as MIN_INLIER_SHARE, and as MIN_OUTSIDE along all sides but one
# To the next best word. Blurred over 0.8 cells, words look much alike: of 100 markers of 10 to 13.5 px that are read
# rightly, 12 have a gap between 0.02 and 0.03.
MIN_SCORE_GAP, WIDE_SCORE_GAP = 0.02, 0.1
SMALL_FIT = 0.97  # of cells below SMALL_CELL: others of 3,648 squares that are no markers have up to 0.968
BEST_FIT = 1.03  # the fit that leaves nothing unexplained
BAD_CELL = 0.4  # of the contrast: a cell whose mean differs more is a bad one
COVERED_CELLS, CODE_COVERED_CELLS = 3, 2  # bad cells, those of the data counted twice; bad data cells
MAX_BAD_RIM = 4  # cells
MIN_INLIER_SHARE = 0.7  # share of the samples that agree with the drawing
MIN_OUTSIDE = -0.3  # of the contrast: paper darker than this along a whole side belongs to something larger, ...
WHOLE_LIKENESS = 0.92  # ... unless the likeness is this high
SURE_MARGIN_CORRELATION = 0.93  # above this correlation, the margin must be right
OVERLAP = 0.4  # of the side: markers nearer to each other are one
MAX_POSE_ERROR = 0.05  # of the side: rms reprojection error of the best pose

# -- Reading of partly covered markers (covered_cells.py)
# Sensitivity: one hard marker less (COVERED_LIKENESS, COVERED_SCORE_GAP). Code words differ in at least 4 cells.
ODD_CELL, ODD_NOISE = (0.15, 0.35), 4.0  # of the contrast, least and most; of the noise: beyond black or white is odd
ODD_PLACES = 2.0  # odd samples: the cell may be covered
BETWEEN_CELL = 0.2  # of the contrast, from grey: may be covered
COVERED_BORDER, COVERED_DEPTH = 0.35, 3  # of the contrast, cells of the border that are not black; cells next to them
MIN_UNCOVERED = 12  # data cells
MAX_UNCOVERED_ERROR = 0.5  # of the contrast, in any cell
MIN_UNCOVERED_SCORE_GAP = 1.0  # squared and summed: to the next word
COVERED_LIKENESS = 0.75  # of a marker that is aligned with this word: accepted; half a marker in the light has had 0.65
COVERED_SCORE_GAP, COVERED_SCORE_GAP_BY_ERROR = 1.4, 2.0  # the same gap, what of the error is added: accepted

# -- Corners of large markers (corners.py, detector.py)
# Sensitivity: up to 0.1 degrees.
MIN_EDGE_SIDE = 36.0  # px, from where on edges are measured
MAX_EDGE_MOVE = 0.2  # cells that they may move a corner
EDGE_REACH, EDGE_BLURS = 2.0, 2.0  # px and blurs that are read to each side of the edge
MAX_EDGE_REACH = 0.4  # cells: paper may end beyond
EDGE_START = 0.15  # cells that the edge may be off at first; where that is beyond the reach it is read twice
MIN_EDGE_STEP, MIN_EDGE_CONTRAST = 0.5, 8.0  # of the median contrast, greys: less is no edge
EDGE_FITS = 3  # what is far off counts less each time
EDGE_OUTLIER, MIN_EDGE_OUTLIER = 3.0, 0.4  # noise, px: what is further off is covered
MIN_EDGE_NOISE = 0.03  # px: rounding, pixels that are no points
MIN_EDGE_SEEN = 0.6  # share of each side
CELL_STEPS = 2  # of the fit to the edges of all cells, from where the outer edges are
CELL_VARIANCE = 2.0  # times that of this fit: errors of neighbouring edges are not independent
LIGHT_STEPS = 2  # of the alignment in light, from where that in greys ends

# Of sheets of unknown shape: cells around each corner, in turn; cells that it may move
CORNER_REACHES, MAX_CORNER_MOVE = (1.0, 0.5), 1.2

# -- Squares of broken outlines (broken_outlines.py)
# Sensitivity, on photos of shadows: none.
MIN_PART = 8.0  # px of the shrunk image: shorter straight parts of outlines do not count
MIN_BROKEN_OUTLINE = 20  # px of the shrunk image: length of an outline
PART_TOLERANCE = 1.5  # px of the shrunk image
PART_SIDE = 2.0  # px to each side of a part, where black and white are read: a lower contrast is no edge
DIRECTIONS, MAX_PARTS = 24, 6  # of the parts; longest parts of each direction
MAX_CORNERS, MAX_BROKEN = 80, 30  # in one image
JOINED_GAP, JOINED_OFF, JOINED_TURN = 1.5, 2.0, 0.996  # of the longer part, px, cosine: parts of one line
CORNER_GAP = 1.0  # of the longer part: how far both may end before the corner
CORNER_SPARE = 0.12  # of the part, of the side: how far one may go beyond a corner
MIN_TURN = 0.5  # sine of the angle at a corner
MIN_OPPOSITE = 0.8  # cosine of the angle between opposite sides
MIN_BROKEN_SIDE = 18.0  # px
MIN_SHOWN = 0.3  # share of the rim that the four parts cover

# -- Reading in uneven light (local_contrast.py, uneven_light.py)
# Sensitivity: none, but the rotation of hard +0.3 (EVEN_INLIER_SHARE), of shadows +0.06 (LOCAL_STEPS). False squares
# have margin ratios of up to 0.17 and score gaps of up to 0.05.
DARK_GREY = 6.0  # greys, added to both sides of an edge: black is never read as less
MIN_LOCAL_CONTRAST, MIN_LOCAL_SHARE = 0.08, 0.4  # of an edge, of the typical one: smaller contrasts are no edges
MIN_LOCAL_STEP = 5.0  # greys
MAX_PLAIN_CONTRAST = 0.5  # of the typical one: an edge in the border without a step
MAX_EDGE_COST = 0.7  # of the typical contrast: worse edges count as this
MIN_LOCAL_RIM = 0.85  # share of the rim that is an edge: worth reading
MIN_FIRST_FIT, MIN_FIRST_SCORE_GAP, MIN_FIRST_PLAIN = 0.66, 0.03, 0.8  # before the edges are aligned: worth that
KNOWN_REACH = 0.8  # of the side: nearer to the middle of a known marker nothing is searched
MAX_LOCAL_READ, MAX_LOCAL = 24, 12  # candidates in one image that are read, whose edges are aligned
EVEN_INLIER_SHARE = 0.87  # share of the samples that agree with the drawing: more needs no look at the edges
LOCAL_REACH = 0.42  # cells: what is read across an edge, at most
MAX_LOCAL_REACH = 2.3  # px
FIRST_LOCAL_REACH = 1.6  # times that, in the first step of a fit that may start far away
LOCAL_STEPS = 4
EDGES_SETTLED = 0.02  # px: a step that moves no edge further is the last
MIN_SEEN_EDGES = 0.6  # share of the edges that are seen and agree
LOCAL_FIT, LOCAL_SCORE_GAP, LOCAL_MARGIN_RATIO = 0.72, 0.035, 0.25  # of the aligned marker: accepted
PLAIN_LOCAL_FIT, PLAIN_LOCAL_MARGIN_RATIO = 0.85, 0.5  # the same of codes with few edges (PLAIN_EDGES)
LOCAL_PLAIN, LOCAL_RIM = 0.75, 0.8  # shares of its edges: accepted
RIM_INSIDE, RIM_NEAR, RIM_FAR = 0.36, 0.14, 0.6  # cells inside the rim, and beyond it, where margins are read
THIN_MARGIN_STEP, THIN_MARGIN_SHARE = 0.75, 0.5  # of the contrast near the rim, share of the rim: less is a thin margin
THIN_MARGIN_REACH, THIN_MARGIN_RIM = 0.15, 0.9  # cells read across the rim, share of it that agrees: accepted
WELL_READ_FIT, WELL_READ_SCORE_GAP = 0.9, 0.1  # of the coarse decoding: read the edges if the greys do not fit
AGAIN_FIT, AGAIN_THIN_FIT = 0.85, 0.75  # of the local contrasts of these: accepted; with a thin margin

# -- A stripe of glare across a marker (glare.py)
# Sensitivity, on photos of glare: greys from 225 on taken for saturated lose one of 16 markers, no greys four.
SATURATED, MIN_SATURATED = 250, 0.003  # grey; share of the marker that is as bright
MIN_GLARE_RIM, MAX_GLARE_READ = 0.6, 40  # share of the rim that is an edge: worth reading; candidates in one image
MIN_GLARE_WHITE = 25.0  # light of white cells, less that of black
MIN_GLARE, MAX_GLARE_ERROR = 0.5, 0.1  # of white: what the stripe adds somewhere; mean error of the border without it
MIN_GLARE_ROOM, MIN_GLARE_SEEN = 0.35, 0.4  # of white: less is not told from black; share of a cell's samples
MIN_GLARE_SCORE_GAP, MAX_GLARE_MISFIT = 1.4, 0.6  # squared and summed over the cells: to the next word, of the best

# -- Stripes of light and shadow (striped_light.py)
# Sensitivity, on photos of shadows: none. Without stripes the share is below 0.6 in nine of ten images, the sum below
# 5 diagonals.
MIN_STRIPED = 0.75  # share of the length of all straight parts that is left when what lies at right angles cancels
MIN_STRIPES = 2.0  # image diagonals, of the same sum: less are a few edges
SAME_STRIPES = (0.9, 0.98, 0.995)  # cosine of twice the angle to the mean, step by step: others are no stripes
MAX_STRIPED_SIDE = 640  # px of the longer side: the light of larger images is found in smaller ones
STRIPE_BLUR = 7  # px of that, along the stripes, against noise
STRIPE_REACH = 0.15  # of the image's longer side: half the length of the longest dark run that counts as print
EVEN_WHITE = 220.0  # grey of what is as bright as the light of its stripe

# -- Bent and creased paper (bent_paper.py, detector.py)
# Sensitivity: up to 0.2 degrees (MIN_BOW, BOW_OF_ONE, BEND_AXES). Sides of flat markers have bows of up to 0.18 px,
# those of bent ones (20 cm) 0.5 to 1.6 px.
BOW_REACH, MIN_BOW = 4.0, 0.22  # px read to each side, px of a side's bow: worth a fit of a cylinder
# Of a flat pose (2 degrees of freedom), in even and in uneven light: above it, a slighter bow is worth such a fit.
# 99 % of 200 flat markers have less than 4, noisy ones up to 15; in soft shadows and glare there are up to 37. Without
# a bow it takes more, since a focal length that is 1 % off gives half of all flat markers more than 20; what no fit
# explains then is doubtful.
MAX_FLAT_CHI2, MAX_UNEVEN_CHI2, MAX_STRAIGHT_CHI2 = 5.0, 60.0, 100.0
SLIGHT_BOW = 0.11  # px
BOW_OVER_NOISE = 3.0  # standard deviations: smaller bows are noise
MAX_BOW = 1.0  # px: doubtful if no cylinder fits
BOW_OF_ONE = 0.5  # weight of the largest bow beside the second largest: an object may cover a part of one side
MIN_BENT_SIDE = 36.0  # px
MIN_BEND = 0.06  # rad over the marker's width: less is flat
MAX_BENT_ERROR, MAX_UNEVEN_ERROR = 0.065, 0.1  # px of the edges, in even, in uneven light: more is doubtful
MAX_BENT_TURN = 0.035  # rad of the rotation's error: more is doubtful
MIN_BENT_SEEN = 0.7  # share of the edges that agree with the cylinder: less is doubtful
BEND_AXES, BEND_STEPS = 4, 4  # directions of the axis that are tried; steps of each
BEND_STARTS = (-0.6, 0.6)  # rad, from which each is tried: from flat paper a fit may stay flat
FOLD_STARTS, CREASE_START = (-0.15, 0.15), 0.2  # rad, widths from the middle: from where a crease is tried
MAX_CREASE = 0.6  # widths from the middle: a crease further away folds at most a corner
BEND_TRIED, BEND_CHOSEN = 2, 2  # steps that all of them get; best ones of each pose that get the others
BEND_FREED = 2  # best ones of each pose, whose axis is then fitted, too
BENT_WAIT = 10  # images of a tracked marker until a fit that was in vain is tried again
BEND_OTHER_TURN, BEND_OTHER_COST = 0.15, 1.3  # rad, of the cost: another pose as good makes a pose doubtful

# -- Errors of corners, poses (pose.py, detector.py)
# Sensitivity: none.
CORNER_MODEL_ERROR = 0.04  # px: corners measured by edges are never known better
# Of 1159 markers of 13 to 25 px, aligned corners are off by 0.015 px (rms, median) where 98 % of the samples agree with
# the drawing, by 0.06 px where 90 % do, by 0.2 px where 80 % do.
ALIGNED_ERROR, MISFIT_ERROR = 0.02, 0.8  # px of the level; px, times the share of samples that disagree
COARSE_CORNER_ERROR = 0.04  # px, times the square of the px between two samples of the alignment
CORNER_NOISE_FACTOR = 1.5  # of the variance that independent samples would give
DEFAULT_CORNER_ERROR = 0.2  # px, of corners without a covariance
UNKNOWN_GAMMA_ERROR = 0.2  # px, of all corners alike, outward: while it is not known whether greys are light
AMBIGUOUS_CHI2 = 16.0  # two poses are ambiguous while chi2 differs less
SAME_ROTATION = math.radians(3.0)  # two poses nearer to each other are one

# -- Tracking (tracker.py)
# Sensitivity: none.
TRACK_MEMORY = 10  # frames that a lost marker is remembered
SEARCHED_FRAMES = 3  # frames that the image around a lost marker is searched
MIN_TRACKED_STEP = 0.1  # of the side: smaller motions need no prediction
SAME_PLACE, SAME_SIZE = 0.1, 1.2  # of the side, ratio: candidates as near and as large are read once
TRACK_REACH = 2.0  # sides that a marker may move in a frame
COVERED_BY = 0.5  # of the side: another marker as near has replaced it
SEARCH_SPARE = 0.5  # of the larger extent, around a lost marker
TURN_SIGMA = math.radians(12.0)  # how far a marker may turn between frames without being odd
MAX_TURN = 0.5  # rad: larger turns count as this
EVIDENCE_DECAY, MAX_EVIDENCE = 0.9, 40.0  # a frame; chi2
EVIDENCE_FRAMES = 2  # frames lost after which earlier evidence is dropped

# -- Bundles (bundle_pose.py)
# Sensitivity: none.
AGREES_PX, AGREES_SHARE = 1.0, 0.05  # px, of the side: rms error of the corners of a marker that agrees with the pose
SOFT_SHARES = (0.6, 0.3, 0.15, 0.08, 0.05, 0.05)  # of the side: the same while the pose is found, step by step
FIRST_TRUST = 0.1  # how much more the first marker of the file counts than the last when they disagree
PLACE_ERROR = 0.002  # of the side: places in the bundle file are never known better
FINAL_STEPS = 4
MAX_HYPOTHESES = 8
BUNDLE_MEMORY = 10  # frames that the last pose of a bundle decides what is ambiguous
