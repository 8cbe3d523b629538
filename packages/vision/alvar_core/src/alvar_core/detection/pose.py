"""Compute the pose of a square marker from its corners: both solutions of the planar ambiguity, and which is likelier.

Infinitesimal plane-based pose estimation (IPPE) gives two start values; a Gauss-Newton step with the covariance of the
corners refines each.

Marker frame: origin in the centre of the black square; looking at the marker as drawn: x right, y up, z out of it.
Camera frame: optical (x right, y down, z forward). Lengths in metres, angles in radians.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Sequence

import cv2
import numpy as np

from alvar_core import native
from alvar_core.arrays import ArrayLike, Floats
from alvar_core.camera import Camera
from alvar_core.detection import thresholds
from alvar_core.rotations import angle_between, quaternion_from_matrix

DEGREES_OF_FREEDOM = 2  # eight corner coordinates minus six of a pose
# p @ _CROSS: the matrix (9 numbers) that takes a turn t to t x p
_CROSS = np.array([[0, 0, 0, 0, 0, 1, 0, -1, 0], [0, 0, -1, 0, 0, 0, 1, 0, 0], [0, 1, 0, -1, 0, 0, 0, 0, 0]], float)


@dataclass
class Solution:
    """A pose of the marker in the camera frame: rotation (3, 3), position (3,) [m], rms error [px], and chi2."""

    rotation: Floats
    position: Floats
    error: float
    chi2: float

    @classmethod
    def of_row(cls, row: Any) -> Solution:
        """Return that of a record of the compiled steps."""
        return cls(row['rotation'], row['position'], float(row['error']), float(row['chi2']))

    @property
    def quaternion(self) -> Floats:
        """Return the orientation x y z w, w >= 0."""
        return quaternion_from_matrix(self.rotation)


def solve(ideal_corners: ArrayLike, sizes: ArrayLike, camera: Camera,
          information: Floats | None = None) -> list[list[Solution]]:
    """Return the solutions of each of M markers, best first (none, one or two).

    ``ideal_corners`` (M, 4, 2) [ideal px]; ``sizes`` (M,) [m]; ``information`` (M, 8, 8) [1/px^2] is the inverse
    covariance of the corners, by default that of independent errors of thresholds.DEFAULT_CORNER_ERROR.
    """
    corners = np.asarray(ideal_corners, np.float64)
    if information is None:
        information = np.broadcast_to(np.eye(8) / thresholds.DEFAULT_CORNER_ERROR ** 2, (len(corners), 8, 8))
    rows = native.steps.solve_poses(corners=corners, sizes=sizes, lens=camera.lens, information=information)
    return [[Solution.of_row(row) for row in both] for both in rows]


def turned_by(turns: Floats, rotations: Floats) -> Floats:
    """Return rotations (B, 3, 3), each followed by a small rotation given as a vector (B, 3) [rad]."""
    return np.array([cv2.Rodrigues(turn)[0] for turn in turns]).reshape(-1, 3, 3) @ rotations


def reprojection_error(turned: Floats, positions: Floats, corners: Floats, camera: Camera) -> Floats:
    """Return the projections of P points minus their measured corners, (B, 2P) [px].

    ``turned`` (B, P, 3) [m]: the points after the rotation; ``positions`` (B, 3) [m]; ``corners`` (B or 1, P, 2) [px].
    """
    p = turned + positions[:, None]
    uv = p[..., :2] / p[..., 2:]
    return (uv * camera.focal + camera.centre - corners).reshape(len(p), -1)


def reprojection(turned: Floats, positions: Floats, corners: Floats, camera: Camera) -> tuple[Floats, Floats]:
    """Return the reprojection_error (B, 2P) and its derivative (B, 2P, 6) by a small rotation and a translation."""
    p = turned + positions[:, None]
    z = p[..., 2:]
    uv = p[..., :2] / z
    error = uv * camera.focal + camera.centre - corners
    by_shift = np.zeros(p.shape[:2] + (2, 3))
    scale = camera.focal / z
    by_shift[..., 0, 0], by_shift[..., 1, 1] = scale[..., 0], scale[..., 1]
    by_shift[..., 2] = -scale * uv
    by_turn = by_shift @ (turned @ _CROSS).reshape(*p.shape[:2], 3, 3)
    return error.reshape(len(p), -1), np.concatenate([by_turn, by_shift], -1).reshape(len(p), -1, 6)


def ambiguity(solutions: Sequence[Solution], degrees_of_freedom: int = DEGREES_OF_FREEDOM) -> tuple[float, bool]:
    """Return (share, ambiguous): the probability of the second solution (0.5: equal to the first), and the flag.

    Solutions that differ by less than thresholds.SAME_ROTATION count as one.
    """
    if are_one(solutions):
        return 0.0, False
    difference = scaled_difference(solutions, degrees_of_freedom)
    return 1 / (1 + math.exp(min(difference / 2, 50))), bool(difference < thresholds.AMBIGUOUS_CHI2)


def are_one(solutions: Sequence[Solution]) -> bool:
    """Return whether there is only one pose, or two that hardly differ."""
    return (len(solutions) < 2
            or angle_between(solutions[0].rotation, solutions[1].rotation) < thresholds.SAME_ROTATION)


def scaled_difference(solutions: Sequence[Solution], degrees_of_freedom: int = DEGREES_OF_FREEDOM) -> float:
    """Return how much larger chi2 of the second solution is; scaled down if even the first fits badly.

    A bad fit means that the errors are not only noise.
    """
    return (solutions[1].chi2 - solutions[0].chi2) / max(1.0, solutions[0].chi2 / degrees_of_freedom)
