"""The compiled steps of the detector: native/module.cpp. Each works as the Python class or function that calls it.

Corners, quads and places are x, y; lengths in pixels of the image or cells of the marker. ``limit`` are the thresholds;
``ended``: a list to which (quad, threshold, value, needed, word) of each candidate that ends is added. ``atlas`` and
``table``: those of Pyramid.memory. Arrays are converted to the type that is needed. Raises ValueError for arrays of
another shape, TypeError for arguments of another type.
"""
from types import ModuleType
from typing import Any, Protocol, Sequence

from alvar_core.arrays import ArrayLike, Bools, Floats, Image, Integers

Ends = list[Any] | None
Missed = tuple[str, float, float] | None  # threshold, value, needed

class AlignmentState(Protocol):
    """The fields of alignment.Alignment, (M, ...) each."""
    h: Floats
    blur: Floats
    level: Integers
    values: Floats
    template: Floats
    model: Floats
    gain: Floats
    dark: Floats
    contrast: Floats
    weights: Floats
    noise: Floats
    normal: Floats
    moved: Floats

class Thresholds:
    """The numbers of detection/thresholds.py that compiled steps use."""
    def __init__(self, module: ModuleType) -> None: ...
    def read(self, module: ModuleType) -> None:
        """Read all thresholds again, which have changed."""

class Lens:
    """A lens with OpenCV's coefficients of distortion, or of its fisheye model; fx, fy, cx, cy [px]."""
    def __init__(self, *, fx: float, fy: float, cx: float, cy: float, k1: float, k2: float, p1: float = 0,
                 p2: float = 0, k3: float, k4: float, k5: float = 0, k6: float = 0, fisheye: bool = False) -> None: ...

class Light:
    """The light of each grey, for a camera whose values are light ** (1 / gamma)."""
    def __init__(self, *, gamma: float) -> None: ...
    @property
    def of_grey(self) -> Floats:
        """The light (256,) of each grey."""
    def halve(self, *, grey: Image, out: Image) -> None:
        """Write an image of half the size, each grey that of the mean light of four."""

class CoarseDecoder:
    """reading.CoarseDecoder: rim (3, 40) and cells (3, P) are homogeneous points, words (P, W); known (1 or W, P).

    blurred: the words of small markers (P, W), or (P, 0).
    """
    def __init__(self, *, half: float, rim: Floats, cells: Floats, words: Floats, blurred: Floats,
                 known: Floats) -> None: ...
    def match(self, *, smooth: Image, quads: Floats, limit: Thresholds, ended: Ends = None) -> dict[str, Any]:
        """Return the fields of reading.CoarseMatch for those of the quads (N, 4, 2) that may be markers."""
    def other_margin(self, *, smooth: Image, corners: Floats) -> Missed:
        """Return NARROWER_MARGIN or WIDER_MARGIN, if the cells fit better with such a border."""

class Reader:
    """reading.Reader for markers of resolution 5: line (S,) [cells], light (S * S, 4), words (25, W)."""
    def __init__(self, *, line: Floats, light: Floats, words: ArrayLike) -> None: ...
    def read(self, *, values: Floats, xx: float, yy: float, noise: float,
             limit: Thresholds) -> tuple[int, float, float]:
        """Return word, fit and score gap of greys (S, S) with a blur of variances xx and yy [cells ** 2]."""

class Aligner:
    """alignment.Aligner: line (S,) [cells], weight (S * S,) of each sample."""
    def __init__(self, *, cells: int, line: Floats, weight: Floats) -> None: ...
    def run(self, *, atlas: Image, table: Floats, lens: Lens, h: Floats, black: Bools, blur: Floats, level: Integers,
            steps: int, redraw: Sequence[int], limit: Thresholds) -> dict[str, Any]:
        """Return the fields of alignment.Alignment after some steps.

        ``redraw``: the steps before which the drawing is computed again.
        """
    def sample(self, *, atlas: Image, table: Floats, lens: Lens, h: Floats, level: Integers) -> Floats:
        """Return the greys (M, S * S) at the samples of markers with homographies h (M, 3, 3)."""

class Features:
    """acceptance.Features of one marker."""
    def __init__(self, *, likeness: float, outside: float, correlation: float, bad_inside: int, bad_rim: int,
                 inlier_share: float, contrast: float, noise: float, blur: float, fit: float, score_gap: float,
                 edges: int,
                 outside_but_one: float) -> None: ...

class Appearance:
    """acceptance.Appearance: share (P,) of each sample, smooth (D, 6) of those of data cells; group (P,): cells."""
    def __init__(self, *, cells: int, weight: float, share: Floats, smooth: Floats, data: Integers, group: Integers,
                 is_data: Bools) -> None: ...
    def features(self, *, state: AlignmentState, noise: Floats, limit: Thresholds) -> Any:
        """Return a record array (M,) with the fields of Features, but without what is read."""

class LocalDecoder:
    """local_contrast.LocalDecoder: three pairs of homogeneous points (3, 2 * pairs) for each edge of cells."""
    def __init__(self, *, rim: Floats, points: Floats, of_code: Bools, costs: Floats) -> None: ...
    def match(self, *, smooth: Image, h: Floats, limit: Thresholds) -> Any:
        """Return a record array (M,) with the fields of local_contrast.LocalMatch."""
    def rim(self, *, smooth: Image, h: Floats, limit: Thresholds) -> tuple[Floats, Floats]:
        """Return the share (M,) of the rim that is an edge, and its contrast (M,)."""

class Search:
    """search.Search: finds markers of resolution 5 whose greys fit their drawing."""
    def __init__(self, *, decoder: CoarseDecoder, aligner: Aligner, appearance: Appearance, reader: Reader,
                 scale: Floats, black_words: Bools, edges: Integers) -> None: ...
    def find(self, *, smooth: Image, atlas: Image, table: Floats, full: Image, lens: Lens, light: Light, ask: bool,
             noise: float, quads: Floats, sizes: Floats, most: int, first: int, limit: Thresholds,
             ended: Ends = None) -> dict[str, Any]:
        """Return ``markers``, ``unsure`` and ``well_read`` as record arrays, ``left_out`` and ``refined`` quads.

        ``ask``: what markers say about the light; sizes (256,) [m]: of the marker with each number; ``most`` candidates
        have a turn, from the ``first`` on.
        """

def noise_of(grey: Image) -> float:
    """Return the standard deviation of an image's noise [greys]."""

def outlines(*, smooth: Image, mean: Image, offset: int, shrink: float, parted: bool,
             limit: Thresholds) -> tuple[Floats, Floats]:
    """Return quads (N, 4, 2) around what is darker than ``mean`` by ``offset``, and, if ``parted``, straight parts."""

def small_squares(*, smooth: Image, quads: Floats, limit: Thresholds) -> Floats:
    """Return quads (M, 4, 2) of finer outlines around those of the quads (N, 4, 2) that are small."""

def refined(*, smooth: Image, quads: Floats, limit: Thresholds, ended: Ends = None) -> Floats:
    """Return the quads (M, 4, 2) with sides that lie on edges."""

def distinct(*, quads: Floats, score: Floats, which: Sequence[int], limit: Thresholds) -> list[int]:
    """Return those of ``which`` that are not near one with a higher score, best first."""

def in_turn(*, quads: Floats, which: Sequence[int], most: int, first: int) -> list[int]:
    """Return the places in ``which`` of the quads whose turn it is."""

def free_of(*, squares: ArrayLike, points: Floats) -> Bools:
    """Return which points (N, 2) lie in none of the squares (K, 3): x and y of the middle, half the side."""

def distinct_parts(*, smooth: Image, parts: Floats, limit: Thresholds) -> Floats:
    """Return the parts (M, 2, 2) that are dark on their right, each once."""

def squares(*, parts: Floats, limit: Thresholds) -> Floats:
    """Return quads (N, 4, 2) made of straight parts, those with most of their rim first."""

def from_square(quads: ArrayLike, half: float) -> Floats:
    """Return the homographies (N, 3, 3) from a square of ``half`` a side to quads."""

def coverage(*, line: Floats, cells: int, variance: ArrayLike) -> Floats:
    """Return how much each place of a line (S,) is covered by each cell: (M, S, cells) for a ``variance`` (M,)."""

def shortfall(*, features: Features, limit: Thresholds) -> Missed:
    """Return what a candidate misses, None for a marker."""

def may_be_covered(*, features: Features, limit: Thresholds) -> bool:
    """Return whether something may cover a part of it."""

def is_sure(*, features: Features, limit: Thresholds) -> bool:
    """Return whether its code is no chance."""

def unpromising(*, h: Floats, blur: float, level: int, likeness: float, cells: int, limit: Thresholds) -> Missed:
    """Return what an aligned candidate misses before its cells are read."""

def edge_points(*, black: Bools, places: Sequence[float] | Floats) -> tuple[Floats, Floats]:
    """Return places (N, 2) [cells] on the edges of cells, and directions (N, 2) from black to white."""

def fit_plane(*, grey: Image, lens: Lens, h: Floats, middle: Floats, outward: Floats, scale: Floats, reach: float,
              first_reach: float, steps: int, light: Light, limit: Thresholds) -> dict[str, Any] | None:
    """Return the fields of edge_alignment.EdgeFit, None if too few edges are seen."""

def fit_curved(*, grey: Image, lens: Lens, cells: int, starts: Floats, middle: Floats, outward: Floats, scale: Floats,
               reach: float, first_reach: float, steps: int, light: Light,
               limit: Thresholds) -> list[dict[str, Any] | None]:
    """Return the fields of an edge_alignment.EdgeFit from each start (K, 8 or 9), None if too few edges are seen."""

def curved_places(*, lens: Lens, cells: int, theta: Floats, points: Floats) -> Floats:
    """Return the places (N, 2) [ideal px] of points (N, 2) [cells] on curved paper."""

def refine_edges(*, grey: Image, lens: Lens, h: Floats, half: float, sigma: Floats, light: Light,
                 limit: Thresholds) -> tuple[Floats, Floats, Bools]:
    """Return corners (M, 4, 2), their covariances (M, 8, 8), and whether all sides are seen (M,)."""

def bows(*, grey: Image, lens: Lens, corners: Floats, cells: int, light: Light, limit: Thresholds) -> Floats:
    """Return how far [px] the sides of markers with corners (M, 4, 2) are from straight."""

def measure_corners(*, aligner: Aligner, atlas: Image, table: Floats, full: Image, lens: Lens, light: Light,
                    state: AlignmentState, black: Bools, inlier_share: Floats, scale: Floats, corners: Floats,
                    limit: Thresholds) -> tuple[Floats, Floats]:
    """Return corners (M, 4, 2) and their information (M, 8, 8), 0 if it cannot be told."""

def solve_poses(*, corners: Floats, sizes: ArrayLike, lens: Lens, information: Floats) -> list[Any]:
    """Return for each marker a record array with up to two pose.Solution, best first."""

def contrasts(*, smooth: Image, h: Floats, points: Floats, limit: Thresholds) -> Floats:
    """Return the contrast (M, pairs) at pairs of points of markers with homographies h (M, 3, 3)."""
