"""Pose of a square marker from its corners: both solutions of the planar ambiguity, weighed.

Marker frame: origin in the centre of the black square; looking at the marker as drawn: x right, y up, z out of it.
Camera frame: optical (x right, y down, z forward).  Lengths in metres, angles in radians.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence

import cv2
import numpy as np

from alvar_core import drawing
from alvar_core.arrays import ArrayLike, Floats
from alvar_core.camera import Camera
from alvar_core.detection import thresholds
from alvar_core.rotations import angle_between, quaternion_from_matrix

DEGREES_OF_FREEDOM = 2  # eight corner coordinates less six of a pose
_DAMPED = 1 + 1e-4 * np.eye(6)  # times the normal equations of a refinement
# p @ _CROSS: the matrix (9 numbers) that takes a turn t to t x p
_CROSS = np.array([[0, 0, 0, 0, 0, 1, 0, -1, 0], [0, 0, -1, 0, 0, 0, 1, 0, 0], [0, 1, 0, -1, 0, 0, 0, 0, 0]], float)


@dataclass
class Solution:
    """One pose: rotation (3, 3) and position (3,) m of the marker in the camera, rms error px, chi2 (weighed)."""

    rotation: Floats
    position: Floats
    error: float
    chi2: float

    @property
    def quaternion(self) -> Floats:
        """Orientation x y z w, w >= 0."""
        return quaternion_from_matrix(self.rotation)


def solve(ideal_corners: ArrayLike, sizes: ArrayLike, camera: Camera,
          information: Floats | None = None) -> list[list[Solution]]:
    """Return for each of M markers its solutions, best first (none, one or two).

    ideal_corners (M, 4, 2) ideal px, sizes (M,) m; information (M, 8, 8): inverse covariance of the corners, 1/px^2
    (without it every coordinate counts with thresholds.DEFAULT_CORNER_ERROR).
    """
    corners = np.asarray(ideal_corners, np.float64)
    if information is None:
        information = np.broadcast_to(np.eye(8) / thresholds.DEFAULT_CORNER_ERROR ** 2, (len(corners), 8, 8))
    found: list[list[Solution]] = [[] for _ in corners]
    if not len(corners):
        return found
    sizes = np.asarray(sizes, np.float64)
    rotations, positions = _both_poses(camera.to_rays(corners), sizes)
    good = np.isfinite(positions).all(1) & np.isfinite(rotations).all((1, 2)) & (positions[:, 2] > 0)
    owner = np.tile(np.arange(len(corners)), 2)[good]
    if len(owner):
        points = drawing.UNIT_CORNERS * sizes[owner, None, None]
        refined = _refine(points, corners[owner], camera, information[owner], rotations[good], positions[good])
        for m, solution in zip(owner, refined):
            found[m].append(solution)
    for solutions in found:
        solutions.sort(key=lambda s: s.chi2)
    return found


def _both_poses(rays: Floats, sizes: Floats) -> tuple[Floats, Floats]:
    """Rotations (2M, 3, 3) and positions (2M, 3), first one then the other pose of each square, from rays (M, 4, 2)."""
    turned = [_both_rotations(*each) for each in zip(rays.tolist(), sizes.tolist())]
    toward, first, other = (np.array(part).reshape(-1, 3, 3) for part in zip(*turned))
    rotations = np.concatenate([toward @ first, toward @ other])
    return rotations, _positions(rotations, np.concatenate([rays, rays]), np.concatenate([sizes, sizes]))


def _both_rotations(rays: Sequence[Sequence[float]], size: float) -> tuple[list[float], list[float], list[float]]:
    """Three matrices, 9 numbers each: what turns the optical axis to the centre of a square seen along four rays, and
    both rotations of the square against that direction.

    After Collins and Bartoli, Infinitesimal Plane-Based Pose Estimation (2014): the homography's derivative in the
    centre of the square fixes the rotation but for a sign.  Plain numbers: arrays of so few take longer.
    """
    try:
        x, y, j00, j01, j10, j11 = _centre_of(rays, size)
        z = 1 / math.sqrt(x * x + y * y + 1)
        cx, cy, x, y = x, y, x * z, y * z
        k = 1 / (1 + z)
        t00, t01, t11 = 1 - x * x * k, -x * y * k, 1 - y * y * k
        b00, b01, b10, b11 = t00 + cx * x, t01 + cx * y, t01 + cy * x, t11 + cy * y
        det = b00 * b11 - b01 * b10
        a00, a01 = (b11 * j00 - b01 * j10) / det, (b11 * j01 - b01 * j11) / det
        a10, a11 = (b00 * j10 - b10 * j00) / det, (b00 * j11 - b10 * j01) / det
        square, det = a00 * a00 + a01 * a01 + a10 * a10 + a11 * a11, a00 * a11 - a01 * a10
        scale = 1 / math.sqrt(0.5 * (square + math.sqrt(max(square * square - 4 * det * det, 0.0))))
    except (ZeroDivisionError, OverflowError):
        nowhere = [math.nan] * 9
        return nowhere, nowhere, nowhere
    a00, a01, a10, a11 = a00 * scale, a01 * scale, a10 * scale, a11 * scale
    u, v = math.sqrt(max(1 - a00 * a00 - a10 * a10, 0.0)), math.sqrt(max(1 - a01 * a01 - a11 * a11, 0.0))
    v = -v if a00 * a01 + a10 * a11 > 0 else v
    normal = a10 * v - u * a11, u * a01 - a00 * v, a00 * a11 - a10 * a01
    return ([t00, t01, x, t01, t11, y, -x, -y, z],
            [a00, a01, normal[0], a10, a11, normal[1], u, v, normal[2]],
            [a00, a01, -normal[0], a10, a11, -normal[1], -u, -v, normal[2]])


def _centre_of(rays: Sequence[Sequence[float]], size: float) -> tuple[float, float, float, float, float, float]:
    """Where the centre of a square of this size is seen, and the derivative there by the marker's x and y (upwards)."""
    (x0, y0), (x1, y1), (x2, y2), (x3, y3) = rays
    ax, ay, bx, by = x1 - x2, y1 - y2, x3 - x2, y3 - y2
    cx, cy = x0 - x1 - bx, y0 - y1 - by
    den = ax * by - bx * ay
    g, h = (cx * by - bx * cy) / den, (ax * cy - cx * ay) / den
    ax, ay, bx, by = x1 - x0 + g * x1, y1 - y0 + g * y1, x3 - x0 + h * x3, y3 - y0 + h * y3
    w = 1 + 0.5 * (g + h)
    cx, cy, w_size = (x0 + 0.5 * (ax + bx)) / w, (y0 + 0.5 * (ay + by)) / w, w * size
    return cx, cy, (ax - cx * g) / w_size, (cx * h - bx) / w_size, (ay - cy * g) / w_size, (cy * h - by) / w_size


def _positions(rotations: Floats, rays: Floats, sizes: Floats) -> Floats:
    """Least squares positions (B, 3) of squares of given rotation seen along rays (B, 4, 2)."""
    p = drawing.UNIT_CORNERS * sizes[:, None, None] @ rotations.transpose(0, 2, 1)
    right = rays * p[..., 2:] - p[..., :2]
    total, rest = rays.sum(1), right.sum(1)
    both = (rays * np.stack([right, rays])).sum((2, 3))  # each point gives two equations: x = u z, y = v z
    z = ((total * rest).sum(1) / 4 - both[0]) / (both[1] - (total * total).sum(1) / 4)
    return np.concatenate([(rest + total * z[:, None]) / 4, z[:, None]], 1)


def _refine(points: Floats, corners: Floats, camera: Camera, information: Floats, rotations: Floats,
            positions: Floats) -> list[Solution]:
    """Solutions after one step of Gauss-Newton on the weighed reprojection, where it helps."""
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
    """Rotations (B, 3, 3), each turned further by a rotation vector (B, 3) rad."""
    return np.array([cv2.Rodrigues(turn)[0] for turn in turns]).reshape(-1, 3, 3) @ rotations


def reprojection_error(turned: Floats, positions: Floats, corners: Floats, camera: Camera) -> Floats:
    """Where P points are seen less where they should be, (B, 2P) px.

    turned (B, P, 3): the points, m, rotated as the camera's axes are; positions (B, 3) m; corners (B or 1, P, 2) px.
    """
    p = turned + positions[:, None]
    uv = p[..., :2] / p[..., 2:]
    return (uv * camera.focal + camera.centre - corners).reshape(len(p), -1)


def reprojection(turned: Floats, positions: Floats, corners: Floats, camera: Camera) -> tuple[Floats, Floats]:
    """The reprojection_error (B, 2P) and its derivative (B, 2P, 6) by a small turn and a shift."""
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
    """Return (share, ambiguous): how likely the second solution is against the first (0.5: both alike), and the flag.

    Solutions that differ by less than thresholds.SAME_ROTATION are one.
    """
    if are_one(solutions):
        return 0.0, False
    difference = scaled_difference(solutions, degrees_of_freedom)
    return 1 / (1 + math.exp(min(difference / 2, 50))), bool(difference < thresholds.AMBIGUOUS_CHI2)


def are_one(solutions: Sequence[Solution]) -> bool:
    """Whether there is only one pose, or two that hardly differ."""
    return (len(solutions) < 2
            or angle_between(solutions[0].rotation, solutions[1].rotation) < thresholds.SAME_ROTATION)


def scaled_difference(solutions: Sequence[Solution], degrees_of_freedom: int = DEGREES_OF_FREEDOM) -> float:
    """How much worse (chi2) the second solution is; less when even the first fits badly: not all is noise then."""
    return (solutions[1].chi2 - solutions[0].chi2) / max(1.0, solutions[0].chi2 / degrees_of_freedom)
