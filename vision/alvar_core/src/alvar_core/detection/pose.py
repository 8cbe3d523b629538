"""Compute the pose of a square marker from its corners: both solutions of the planar ambiguity, and which is likelier.

OpenCV's IPPE gives two start values; a Gauss-Newton step with the covariance of the corners refines each.

Marker frame: origin in the centre of the black square; looking at the marker as drawn: x right, y up, z out of it.
Camera frame: optical (x right, y down, z forward). Lengths in metres, angles in radians.
"""
from __future__ import annotations

import ctypes
import math
from dataclasses import dataclass
from typing import Sequence

import cv2
import numpy as np

from alvar_core import drawing, native
from alvar_core.arrays import ArrayLike, Floats, Integers
from alvar_core.camera import Camera
from alvar_core.detection import thresholds
from alvar_core.rotations import angle_between, quaternion_from_matrix

DEGREES_OF_FREEDOM = 2  # eight corner coordinates minus six of a pose
_RAYS_CAMERA = np.eye(3)  # the camera matrix of rays x / z, y / z
_DAMPED = 1 + 1e-4 * np.eye(6)  # times the normal equations of a refinement
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
    def of_row(cls, row: Floats) -> Solution:
        """Return that of a row of native/pose.cpp."""
        return cls(row[:9].reshape(3, 3), row[9:12], float(row[12]), float(row[13]))

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
    found: list[list[Solution]] = [[] for _ in corners]
    if not len(corners):
        return found
    sizes = np.asarray(sizes, np.float64)
    if native.library:
        return _solve_compiled(native.library, corners, sizes, camera, information)
    owners, rotations, positions = _both_poses(camera.to_rays(corners), sizes)
    if len(owners):
        points = drawing.UNIT_CORNERS * sizes[owners, None, None]
        refined = _refine(points, corners[owners], camera, information[owners], rotations, positions)
        for m, solution in zip(owners, refined):
            found[m].append(solution)
    for solutions in found:
        solutions.sort(key=lambda s: s.chi2)
    return found


def _solve_compiled(library: ctypes.CDLL, corners: Floats, sizes: Floats, camera: Camera,
                    information: Floats) -> list[list[Solution]]:
    """Do the same as ``solve`` with the compiled step of native/pose.cpp."""
    corners, sizes, information = (np.ascontiguousarray(each, np.float64) for each in (corners, sizes, information))
    rows, found = np.empty((len(corners), 2, 14)), np.empty(len(corners), np.int32)
    lens, place = np.concatenate([camera.focal, camera.centre]), native.address
    library.alvar_poses(len(corners), place(corners), place(sizes), place(lens), place(information), place(rows),
                        place(found))
    return [[Solution.of_row(row) for row in both[:count]] for both, count in zip(rows, found.tolist())]


def _both_poses(rays: Floats, sizes: Floats) -> tuple[Integers, Floats, Floats]:
    """Return both poses of squares seen along rays (M, 4, 2); leave out squares without a pose.

    The result is the index of the square of each pose (B,), rotations (B, 3, 3) and positions (B, 3).
    """
    owners, rotations, positions = [], [], []
    for m, (seen, size) in enumerate(zip(rays, sizes)):
        _, turns, shifts, _ = cv2.solvePnPGeneric(drawing.UNIT_CORNERS * size, seen, _RAYS_CAMERA, None,
                                                  flags=cv2.SOLVEPNP_IPPE_SQUARE)
        for turn, shift in zip(turns, shifts):
            if np.isfinite(turn).all() and shift[2, 0] > 0:
                owners.append(m)
                rotations.append(cv2.Rodrigues(turn)[0])
                positions.append(shift[:, 0])
    return (np.array(owners, int), np.array(rotations, float).reshape(-1, 3, 3),
            np.array(positions, float).reshape(-1, 3))


def _refine(points: Floats, corners: Floats, camera: Camera, information: Floats, rotations: Floats,
            positions: Floats) -> list[Solution]:
    """Return the Solutions after a Gauss-Newton step on the weighted reprojection error, where it reduces that."""
    turned = points @ rotations.transpose(0, 2, 1)
    residual, jacobian = reprojection(turned, positions, corners, camera)
    jw = jacobian.transpose(0, 2, 1) @ information
    normal = jw @ jacobian
    normal *= _DAMPED
    step = -np.linalg.solve(normal, jw @ residual[:, :, None])[:, :, 0]
    rotations = np.stack([turned_by(step[:, :3], rotations), rotations])
    positions = np.stack([positions + step[:, 3:], positions])
    after = reprojection_error(points @ rotations[0].transpose(0, 2, 1), positions[0], corners, camera)
    residual = np.stack([after, residual])
    cost = (residual[:, :, None] @ information @ residual[..., None])[..., 0, 0]
    cost[~(positions[..., 2] > 0)] = np.inf
    error = np.sqrt((residual * residual).sum(2) / 4)
    better = (cost[0] > cost[1]).astype(int).tolist()
    return [Solution(rotations[k, b], positions[k, b], float(error[k, b]), float(cost[k, b]))
            for b, k in enumerate(better)]


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
