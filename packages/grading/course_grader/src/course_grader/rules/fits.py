"""How well a path fits a shape of unknown position, size and direction: the shape is fitted first, then compared.

A path is an array of shape (n, 2) of positions [m]. Its start is left out as far as that improves the fit, because many
programs drive to the shape first; the rest must lie on the outline, and the outline must be covered.
"""
import itertools
import math
from typing import Callable, List, NamedTuple, Optional, Sequence, Tuple

import cv2
import numpy as np

from plain_support.arrays import ArrayLike, Floats

SMALLEST = 5.0  # tolerances: the smallest extent of a shape
SAMPLES = 240  # points on the path and on the outline that are compared
APPROACHES = np.linspace(0.0, 0.7, 36)  # shares of the path that may be the way to the shape
SHARPEST = math.radians(25.0)  # the smallest angle of a triangle
CORNERS = 40  # points of a hull among which a triangle's corners are searched
FORGIVING = 2.0  # tolerances from the outline, where a path counts 0


class Fit(NamedTuple):
    """The best fit: quality 0..1, size [m] (side, diameter), outline (n, 2) [m], and the two shares it consists of.

    ``traces``: the parts of the path, each (n, 2) [m], that lie on the outline.
    """

    quality: float
    size: float
    outline: Floats
    on_outline: float  # of the path, lies on the outline
    covered: float  # of the outline, was drawn
    traces: Tuple[Floats, ...] = ()


NO_FIT = Fit(0.0, 0.0, np.empty((0, 2)), 0.0, 0.0)


def path_length(path: Sequence[Tuple[float, float]]) -> float:
    """Return the length [m] of a path."""
    return float(sum(math.dist(a, b) for a, b in zip(path, path[1:])))


def corners(path: Sequence[Tuple[float, float]], tolerance: float = 0.05) -> List[Tuple[float, float]]:
    """Return the positions [(x, y)] between which a path is straight within ``tolerance`` [m], its ends included."""
    if len(path) < 2:
        return list(path)
    points = np.asarray(path, np.float32).reshape(-1, 1, 2)
    return [(float(x), float(y)) for x, y in cv2.approxPolyDP(points, tolerance, False).reshape(-1, 2)]


def resample(path: ArrayLike, samples: int = SAMPLES) -> Floats:
    """Return ``samples`` points at equal distances along a path; an empty array for a path without length."""
    points = np.asarray(path, float).reshape(-1, 2)
    steps = np.hypot(*np.diff(points, axis=0).T) if len(points) > 1 else np.zeros(0)
    along = np.concatenate(([0.0], np.cumsum(steps)))
    if along[-1] <= 0.0:
        return np.empty((0, 2))
    even = np.linspace(0.0, along[-1], samples)
    return np.column_stack([np.interp(even, along, points[:, axis]) for axis in (0, 1)])


def fit(path: ArrayLike, shape: str, tolerance: float, line: ArrayLike = ()) -> Fit:
    """Return the Fit of a path to one of the SHAPES, or to a ``line`` through points (n, 2) [m], where that lies.

    Within ``tolerance`` [m] a point is on it.
    """
    even = resample(path, 2 * SAMPLES)
    best = NO_FIT
    for share in APPROACHES:
        rest = even[int(share * len(even)):]
        if len(rest) <= 8:
            continue
        outline, size = (_line(line) if shape == LINE else _outline(rest, shape, SMALLEST * tolerance))
        if outline is None:
            continue
        widest = math.inf if shape == LINE else SHAPES[shape].max_tolerance * size
        candidate = compared(rest, resample(outline), min(tolerance, widest), size)
        if candidate.quality > best.quality + 1e-9:
            best = candidate
        if best.quality >= 1.0:
            break
    return best


def compared(path: Floats, outline: Floats, tolerance: float, size: float = 0.0) -> Fit:
    """Return the Fit of points of a path to points of an outline at equal distances, each of shape (n, 2) [m]."""
    distances = np.hypot(path[:, None, 0] - outline[None, :, 0], path[:, None, 1] - outline[None, :, 1])
    step = np.hypot(*(outline[1] - outline[0])) / 2.0  # between two points of the outline
    near = _shares(distances.min(axis=1) - step, tolerance)
    on_outline = near.mean()
    covered = _shares(distances.min(axis=0) - step, tolerance).mean()
    runs = np.split(path, np.flatnonzero(np.diff(near >= 1.0)) + 1)
    traces = tuple(runs[0 if near[0] >= 1.0 else 1::2])
    return Fit(float(on_outline * covered), size, outline, float(on_outline), float(covered), traces)


def _shares(distances: Floats, tolerance: float) -> Floats:
    """Return 1 within the tolerance, falling to 0 at FORGIVING times it."""
    shares: Floats = np.clip((FORGIVING - distances / tolerance) / (FORGIVING - 1.0), 0.0, 1.0)
    return shares


def _outline(points: Floats, shape: str, smallest: float) -> Tuple[Optional[Floats], float]:
    """Return (closed outline, size) of the shape that the points show, or (None, 0)."""
    if min(np.ptp(points, axis=0)) < smallest:
        return None, 0.0
    return SHAPES[shape].outline(points)


def _line(points: ArrayLike) -> Tuple[Floats, float]:
    """Return a line through points, and its length."""
    line = np.asarray(points, float).reshape(-1, 2)
    return line, float(np.hypot(*np.diff(line, axis=0).T).sum())


def _circle(points: Floats) -> Tuple[Floats, float]:
    """Least squares of x^2 + y^2 = 2 a x + 2 b y + c (Kasa 1976)."""
    matrix = np.column_stack([2.0 * points, np.ones(len(points))])
    a, b, c = np.linalg.lstsq(matrix, (points ** 2).sum(axis=1), rcond=None)[0]
    radius = math.sqrt(max(c + a * a + b * b, 0.0))
    angles = np.linspace(0.0, 2.0 * math.pi, SAMPLES)
    return np.column_stack([a + radius * np.cos(angles), b + radius * np.sin(angles)]), 2.0 * radius


def _eight(points: Floats) -> Tuple[Floats, float]:
    """Two circles that touch, in the rectangle of least area around the points: twice as long as it is wide."""
    (x, y), (width, height), degrees = cv2.minAreaRect(points.astype(np.float32))
    radius = (width + height) / 6.0
    heading = math.radians(degrees) + (0.0 if width > height else math.pi / 2.0)
    angles = np.linspace(0.0, 2.0 * math.pi, SAMPLES // 2)
    loop = np.column_stack([1.0 - np.cos(angles), np.sin(angles)])  # begins where the circles touch
    along, across = (radius * np.vstack([loop, loop * (-1.0, 1.0)])).T
    cos, sin = math.cos(heading), math.sin(heading)
    return np.column_stack([x + along * cos - across * sin, y + along * sin + across * cos]), 2.0 * radius


def _square(points: Floats) -> Tuple[Floats, float]:
    """The rectangle of least area around the points, made a square of the same circumference."""
    centre, (width, height), angle = cv2.minAreaRect(points.astype(np.float32))
    side = (width + height) / 2.0
    corners = cv2.boxPoints((centre, (side, side), angle))
    return np.vstack([corners, corners[:1]]), side


def _triangle(points: Floats) -> Tuple[Optional[Floats], float]:
    """The largest triangle with corners on the path, unless one of its angles is too small.

    OpenCV's minEnclosingTriangle is no help: it fails for some paths and never ends for others (5.0).
    """
    hull = cv2.convexHull(points.astype(np.float32)).reshape(-1, 2).astype(float)
    hull = hull[np.unique(np.linspace(0, len(hull) - 1, CORNERS).astype(int))] if len(hull) > CORNERS else hull
    triples = np.array(list(itertools.combinations(range(len(hull)), 3)))
    if not len(triples):
        return None, 0.0
    a, b, c = (hull[triples[:, corner]] for corner in range(3))
    areas = np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    corners = hull[triples[areas.argmax()]]
    lengths = np.hypot(*(corners - np.roll(corners, 1, axis=0)).T)
    # the sharpest angle lies opposite to the shortest side; the area is half of the product of its legs and sine
    legs = np.sort(lengths)[1:]
    if areas.max() <= legs.prod() * math.sin(SHARPEST):
        return None, 0.0
    return np.vstack([corners, corners[:1]]), float(lengths.mean())


class Shape(NamedTuple):
    """A shape: the function that finds its closed outline and size in points, and its number of sides, 0 for a circle.

    ``max_tolerance``: as a share of the size; wider tolerances confuse the shapes.
    """

    outline: Callable[[Floats], Tuple[Optional[Floats], float]]
    max_tolerance: float
    sides: int


SHAPES = {'circle': Shape(_circle, 0.025, 0), 'square': Shape(_square, 0.05, 4), 'triangle': Shape(_triangle, 0.05, 3),
          'eight': Shape(_eight, 0.05, 0)}
LINE = 'line'  # instead of a shape: a line through given points, which has no position and size of its own
SIDES = {**{name: shape.sides for name, shape in SHAPES.items()}, LINE: 0}
