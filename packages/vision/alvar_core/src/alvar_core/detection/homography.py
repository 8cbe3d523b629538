"""Homographies in batches of M: compute them from four corners, apply them to points, change them slightly."""
from __future__ import annotations

import functools

import numpy as np

from alvar_core import native
from alvar_core.arrays import ArrayLike, Floats

_SMALL = np.zeros((8, 9))  # the element of the matrix that each small change adds to
_SMALL[range(8), [2, 0, 1, 5, 3, 4, 6, 7]] = 1, 1, 1, 1, 1, 1, -1, -1
_IDENTITY = np.eye(3)


def from_square(quads: ArrayLike, half: float) -> Floats:
    """Return homographies (M, 3, 3) from the square [-half, half]^2 (y down) to quads (M, 4, 2).

    The corners of a quad are top left, then clockwise in the image.
    """
    found: Floats = native.steps.from_square(quads, half)
    return found


def apply(h: Floats, points: ArrayLike) -> Floats:
    """Return points (P, 2) or (M, P, 2) transformed by ``h`` (M, 3, 3), as (M, P, 2)."""
    points = np.asarray(points, np.float64)
    p = points @ np.swapaxes(h[:, :, :2], 1, 2) + h[:, None, :, 2]
    return p[..., :2] / p[..., 2:]


def small(d: Floats) -> Floats:
    """Return (M, 3, 3) from small changes (M, 8): identity plus [[d1, d2, d0], [d4, d5, d3], [-d6, -d7, 0]]."""
    return (d @ _SMALL).reshape(-1, 3, 3) + _IDENTITY


@functools.lru_cache(maxsize=16)
def _small_moves(half: float) -> tuple[Floats, Floats]:
    """Return the corners (4, 3, 1), homogeneous, and their derivative (4, 3, 8) by small changes of ``h``."""
    corners = np.array([[-half, -half, 1], [half, -half, 1], [half, half, 1], [-half, half, 1]])[:, :, None]
    return corners, np.array([(small(np.eye(8)) @ corner - corner)[..., 0].T for corner in corners])


def corner_derivative(h: Floats, half: float) -> Floats:
    """Return the derivative (M, 8, 8) of the corners of [-half, half]^2 [px] by small changes (``small``) of ``h``."""
    corners, moves = _small_moves(half)
    h = h[:, None]
    p = h @ corners  # (M, 4, 3, 1)
    derivative: Floats = (h[:, :, :2] - p[:, :, :2] / p[:, :, 2:] * h[:, :, 2:]) / p[:, :, 2:] @ moves
    return derivative.reshape(-1, 8, 8)


def area(quads: Floats) -> Floats:
    """Return the signed area (M,) of quads (M, 4, 2), positive if the corners are clockwise in an image (y down)."""
    d = quads[..., :2, :] - quads[..., 2:, :]  # both diagonals
    return 0.5 * (d[..., 0, 0] * d[..., 1, 1] - d[..., 0, 1] * d[..., 1, 0])


def mean_side(quads: Floats) -> Floats:
    """Return the side (M,) of squares with the same area as quads (M, 4, 2), clockwise or not."""
    return np.sqrt(np.abs(area(quads)))
