"""Align a marker with the edges of its cells, whatever the light is.

Across each edge between a black and a white cell, and between the black square and the paper around it, the position of
the step is measured relative to the black and white beside it. A robust fit then moves the marker; edges that a
shadow disturbs are outliers of this fit. Coordinates are in cells as in alignment.py.
"""
from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from alvar_core import native
from alvar_core.arrays import Bools, Floats, Image
from alvar_core.camera import Camera
from alvar_core.detection import homography, thresholds
from alvar_core.detection.light import LINEAR, Light

PLACES = np.array([-0.25, 0.25])  # along an edge, where a marker that is flat is read


@dataclass
class EdgePoints:
    """Points on edges: ``middle`` (P, 2) [cells], ``outward`` (P, 2): the direction from black to white."""

    middle: Floats
    outward: Floats


def scale_of(half: float) -> Floats:
    """Return small changes (8,) of a homography that move the corners, at +-``half`` cells, equally far."""
    return 1e-3 / np.array([1 / half, 1, 1, 1 / half, 1, 1, half, half])


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


def fit_plane(grey: Image, camera: Camera, h: Floats, points: EdgePoints, scale: Floats, reach: float,
              steps: int, light: Light = LINEAR) -> EdgeFit | None:
    """Return the EdgeFit of a flat marker, starting from a homography ``h`` (3, 3); None if too few edges are seen.

    Its parameters (8,) are small changes of ``h`` (homography.small). The edges are those of the ``light``. ``scale``
    (8,): small changes of the parameters; ``reach`` [px]: half the width that is read across an edge, in the first
    step FIRST_LOCAL_REACH times as much.
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
