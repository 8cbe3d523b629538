"""Align a marker with the edges of its cells, whatever the light is.

Across each edge between a black and a white cell, and between the black square and the paper around it, the position of
the step is measured relative to the black and white beside it. A robust fit then moves the marker; edges that a
shadow disturbs are outliers of this fit. Coordinates are in cells as in alignment.py.
"""
from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np

from alvar_core import native
from alvar_core.arrays import Bools, Floats, Image, Integers
from alvar_core.camera import Camera
from alvar_core.detection import homography, thresholds
from alvar_core.detection.light import LINEAR, Light

PLACES = np.array([-0.25, 0.25])  # along an edge, where a marker that is flat is read


@dataclass
class EdgePoints:
    """Points on edges: ``middle`` (P, 2) [cells], ``outward`` (P, 2): the direction from black to white."""

    middle: Floats
    outward: Floats

    def __post_init__(self) -> None:
        self.across: Floats = np.ascontiguousarray(self.outward.T)
        self.along: Floats = self.across[::-1] * [[1], [-1]]


class SeenEdges(NamedTuple):
    """Where a Model with parameters (K, n) has the edges in the image.

    ``at`` (K, 2, P) [ideal px]; ``direction`` (K, 2, P): across the edge, from black to white, of length 1;
    ``jacobian`` (K, n, P): derivative of ``at`` along ``direction``.
    """

    at: Floats
    direction: Floats
    jacobian: Floats


def scale_of(half: float) -> Floats:
    """Return small changes (8,) of a homography that move the corners, at +-``half`` cells, equally far."""
    return 1e-3 / np.array([1 / half, 1, 1, 1 / half, 1, 1, half, half])


class Model:
    """Where points of a marker are in the image, by parameters (K, n)."""

    def edges(self, theta: Floats, points: EdgePoints) -> SeenEdges:
        """Return the SeenEdges with parameters ``theta`` (K, n)."""
        raise NotImplementedError


@dataclass
class EdgeFit:
    """The result of a fit.

    ``parameters`` (n,), their ``covariance`` (n, n); ``error`` [px]: typical residual of the edges; ``agrees`` (P,):
    which points are edges where the model has them, ``seen``: their share; ``cost`` [px^2]: sum of the squared
    residuals, each at most 1.
    """

    parameters: Floats
    covariance: Floats
    error: float
    agrees: Bools
    cost: float

    @property
    def seen(self) -> float:
        """Return the share of the points that are edges and agree."""
        return float(self.agrees.mean())


def edge_points(black: Bools, places: Floats) -> EdgePoints:
    """Return the points on the edges of a marker's cells (n, n), bool; ``places`` along each edge, -0.5 to 0.5."""
    return EdgePoints(*native.steps.edge_points(black=black, places=places))


def edges_of_cells(black: Bools) -> EdgePoints:
    """Return the points on the edges of a marker's cells (n, n), bool; those of most markers are kept."""
    return _kept_edges(black.tobytes(), len(black))


@functools.lru_cache(maxsize=1024)  # as many as there are numbers in four orientations
def _kept_edges(black: bytes, cells: int) -> EdgePoints:
    return edge_points(np.frombuffer(black, bool).reshape(cells, cells), PLACES)


class EdgeAligner:
    """Fits a Model to the edges in an image."""

    ACROSS = np.linspace(-1, 1, 15, dtype=np.float32)

    def __init__(self) -> None:
        self._ends = np.zeros((len(self.ACROSS), 3), np.float32)
        self._ends[:3, 0] = self._ends[-3:, 1] = 1 / 3
        self._ends[:, 2] = 1 / len(self.ACROSS)

    def fit(self, grey: Image, camera: Camera, model: Model, starts: Floats, points: EdgePoints, scale: Floats,
            reach: float, steps: int, first_reach: float | None = None,
            light: Light = LINEAR) -> list[EdgeFit | None]:
        """Return the EdgeFit of a model from each of ``starts`` (K, n); None if too few edges are seen.

        The edges are those of the ``light``. ``scale`` (m,): small changes of the first m parameters, the others stay;
        ``reach`` [px]: half the width that is read across an edge, ``first_reach`` that of the first step (None:
        FIRST_LOCAL_REACH times as much).
        """
        if first_reach is None:
            first_reach = thresholds.FIRST_LOCAL_REACH * reach
        seen, theta = light.of(grey), starts.astype(np.float64)
        count, free = len(theta), len(scale)
        seen_enough = np.ones(count, bool)
        for step in range(steps):
            at, direction, jacobian = model.edges(theta, points)
            jacobian = jacobian[:, :free] * scale[:, None]
            offset, good = self._offsets(seen, light, camera, at, direction, reach if step else first_reach)
            visible = good.sum(1)
            seen_enough &= visible >= 3 * free
            if not seen_enough.any():
                return [None] * count
            middle = np.minimum(visible // 2, good.shape[1] - 1)
            by_row, size = jacobian.transpose(0, 2, 1), np.abs(offset)
            error, weight = _weights(size, good, middle)
            for _ in range(3):
                weighted = jacobian * weight[:, None]
                normal = weighted @ by_row
                diagonal = normal.reshape(count, -1)[:, ::free + 1]
                diagonal += 1e-9 * (diagonal.sum(1, keepdims=True) + 1e-9)
                change = np.linalg.solve(normal, weighted @ offset[..., None])
                moved = (by_row @ change)[..., 0]
                size = np.abs(offset - moved)
                error, weight = _weights(size, good, middle)
            theta[:, :free] += change[..., 0] * scale
            if step and np.abs(moved[seen_enough]).max() < thresholds.EDGES_SETTLED:
                break
        covariance = np.linalg.inv(normal) * (np.maximum(error, 0.03) ** 2)[:, None, None] * np.outer(scale, scale)
        agrees = good & (weight > 0.1)
        cost = np.where(good, np.minimum(size * size, 1.0), 1.0).sum(1)
        return [EdgeFit(theta[k], covariance[k], float(error[k]), agrees[k], float(cost[k])) if seen_enough[k]
                else None for k in range(count)]

    def _offsets(self, seen: Image | Floats, light: Light, camera: Camera, at: Floats, direction: Floats,
                 reach: float) -> tuple[Floats, Bools]:
        """Return how far [px] the edges lie beyond the points, and which are edges, each (K, P)."""
        where = at.astype(np.float32)[..., None] + direction.astype(np.float32)[..., None] * (reach * self.ACROSS)
        count = len(where)
        x, y = camera.to_real(where[:, 0].reshape(count, -1), where[:, 1].reshape(count, -1))
        read = cv2.remap(seen, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        black, white, mean = (read.astype(np.float32).reshape(-1, len(self.ACROSS)) @ self._ends).T.reshape(
            3, count, -1)
        step = white - black
        low, high = light.greys(black), light.greys(white)
        good = (high - low > thresholds.MIN_LOCAL_CONTRAST * (high + low + thresholds.DARK_GREY))
        good &= high - low > thresholds.MIN_LOCAL_STEP
        good &= (mean >= black) & (mean <= white)  # else the step lies beyond the samples
        for place, size in (x, seen.shape[1]), (y, seen.shape[0]):
            if not (place.min() > 0 and place.max() < size - 1):
                ends = place.reshape(*good.shape, -1)[..., ::len(self.ACROSS) - 1]
                good &= ((ends > 0) & (ends < size - 1)).all(-1)
        share = (mean - black) / np.where(good, step, 1.0)
        offset = (1 - 2 * share) * (reach * len(self.ACROSS) / (len(self.ACROSS) - 1))
        return np.where(good, offset, 0.0).astype(np.float64), good


def _weights(size: Floats, good: Bools, middle: Integers) -> tuple[Floats, Floats]:
    """Return the typical one (K,) [px] of the sizes of residuals (K, P), and their weights: outliers have weight 0.

    ``middle`` (K,): half the number of the ``good`` ones; the others have weight 0.
    """
    size = np.where(good, size, np.inf)
    if len(size) == 1:
        error = 1.4826 * np.partition(size, middle[0], 1)[:, middle[0]]
    else:
        error = 1.4826 * np.sort(size, 1)[np.arange(len(size)), middle]
        error[np.isinf(error)] = 0.0  # a start from which no edge is seen: all weights are 0
    size /= (thresholds.EDGE_OUTLIER * np.maximum(error, thresholds.MIN_EDGE_OUTLIER / 3))[:, None]
    np.minimum(size, 1, out=size)
    size *= size
    np.subtract(1, size, out=size)
    size *= size
    return error, size


def directions(along: Floats, outward: Floats) -> Floats:
    """Return the directions (K, 2, P), of length 1, at a right angle to edges ``along``, on the side of ``outward``."""
    # the gradient of an edge is at a right angle to it in the image
    out = np.stack([-along[:, 1], along[:, 0]], 1)
    length = np.sqrt((out * out).sum(1)) + 1e-12
    out *= (np.sign((out * outward).sum(1)) / length)[:, None]
    return out


def fit_plane(grey: Image, camera: Camera, h: Floats, points: EdgePoints, scale: Floats, reach: float,
              steps: int, light: Light = LINEAR) -> EdgeFit | None:
    """Return the EdgeFit of a flat marker, starting from a homography ``h`` (3, 3); None if too few edges are seen.

    Its parameters (8,) are small changes of ``h`` (homography.small). ``scale`` and ``reach`` are those of
    EdgeAligner.fit.
    """
    found = native.steps.fit_plane(grey=grey, lens=camera.lens, h=h, middle=points.middle, outward=points.outward,
                                   scale=scale, reach=reach, first_reach=thresholds.FIRST_LOCAL_REACH * reach,
                                   steps=steps, light=light.steps, limit=native.limit)
    return None if found is None else EdgeFit(**found)


def changed(h: Floats, theta: Floats) -> Floats:
    """Return the homography (3, 3) after small changes (8,)."""
    out: Floats = (h @ homography.small(theta[None]))[0]
    out /= out[2, 2]
    return out
