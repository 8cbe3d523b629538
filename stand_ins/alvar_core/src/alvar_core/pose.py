"""Pose of a square marker from its corners: both solutions of the planar ambiguity, weighed.

Marker frame: origin in the centre of the black square; looking at the marker as drawn: x right, y up, z out of it.
Camera frame: optical (x right, y down, z forward).  Lengths in metres, angles in radians.
"""
import math
from dataclasses import dataclass

import numpy as np

from alvar_core import homography

AMBIGUOUS_CHI2 = 16.0
DEGREES_OF_FREEDOM = 2  # eight corner coordinates less six of a pose
SAME_ROTATION = np.radians(3.0)
DEFAULT_CORNER_SIGMA = 0.2  # px
DAMPING = 1e-4
MODEL_ERROR = 0.04  # px: corners are never known better


@dataclass
class Solution:
    """One pose: rotation (3, 3) and position (3,) m of the marker in the camera, rms error px, chi2 (weighed)."""

    rotation: np.ndarray
    position: np.ndarray
    error: float
    chi2: float

    @property
    def quaternion(self):
        """Orientation x y z w, w >= 0."""
        return quaternion(self.rotation)


def object_corners(size):
    """(4, 3) corners in the marker frame: top left, top right, bottom right, bottom left."""
    half = size / 2.0
    return np.array([[-half, half, 0], [half, half, 0], [half, -half, 0], [-half, -half, 0]])


def quaternion(rotation):
    """Quaternion x y z w (w >= 0) of a rotation matrix."""
    m = rotation
    k = np.array([[m[0, 0] - m[1, 1] - m[2, 2], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0], m[2, 1] - m[1, 2]],
                  [0, m[1, 1] - m[0, 0] - m[2, 2], m[1, 2] + m[2, 1], m[0, 2] - m[2, 0]],
                  [0, 0, m[2, 2] - m[0, 0] - m[1, 1], m[1, 0] - m[0, 1]],
                  [0, 0, 0, m[0, 0] + m[1, 1] + m[2, 2]]]) / 3
    q = np.linalg.eigh(k, UPLO='U')[1][:, 3]
    return q if q[3] >= 0 else -q


def angle_between(a, b):
    """Angle of the rotation from a to b, radians."""
    return math.acos(min(1.0, max(-1.0, (float(np.vdot(a, b)) - 1) / 2)))


def solve(ideal_corners, sizes, camera, information=None):
    """Return for each of M markers its solutions, best first (none, one or two).

    ideal_corners (M, 4, 2) ideal px, sizes (M,) m; information (M, 8, 8): inverse covariance of the corners, 1/px^2
    (without it every coordinate counts with DEFAULT_CORNER_SIGMA).
    """
    corners = np.asarray(ideal_corners, np.float64)
    if information is None:
        information = np.broadcast_to(np.eye(8) / DEFAULT_CORNER_SIGMA ** 2, (len(corners), 8, 8))
    found = [[] for _ in corners]
    if not len(corners):
        return found
    sizes = np.asarray(sizes, np.float64)
    rotations, positions = _both_poses(camera.to_rays(corners), sizes)
    good = np.isfinite(positions).all(1) & np.isfinite(rotations).all((1, 2)) & (positions[:, 2] > 0)
    owner = np.tile(np.arange(len(corners)), 2)[good]
    if len(owner):
        points = object_corners(1.0) * sizes[owner, None, None]
        refined = _refine(points, corners[owner], camera, information[owner], rotations[good], positions[good])
        for m, solution in zip(owner, refined):
            found[m].append(solution)
    for solutions in found:
        solutions.sort(key=lambda s: s.chi2)
    return found


def _both_poses(rays, sizes):
    """Rotations (2M, 3, 3) and positions (2M, 3), first one then the other pose of each square, from rays (M, 4, 2).

    After Collins and Bartoli, Infinitesimal Plane-Based Pose Estimation (2014): the homography's derivative in the
    centre of the square fixes the rotation but for a sign.
    """
    h = homography.from_square(rays, 0.5) * [1.0, -1.0, 1.0]  # marker y is up
    centre = h[:, :2, 2]
    toward = _turn_to(centre)
    both = np.stack([h, toward])
    jacobian, basis = both[..., :2, :2] - centre[..., None] * both[..., 2:, :2]
    a = np.linalg.solve(basis, jacobian / sizes[:, None, None])
    square = (a * a).sum((1, 2))
    det = a[:, 0, 0] * a[:, 1, 1] - a[:, 0, 1] * a[:, 1, 0]
    scale = np.sqrt(0.5 * (square + np.sqrt(np.maximum(square ** 2 - 4 * det ** 2, 0))))
    columns = np.empty((2, len(a), 3, 3))
    columns[:, :, :2, :2] = r = a / scale[:, None, None]
    third = np.sqrt(np.maximum(1 - (r * r).sum(1), 0))
    third[:, 1] *= np.where((r[:, :, 0] * r[:, :, 1]).sum(1) > 0, -1, 1)
    columns[0, :, 2, :2], columns[1, :, 2, :2] = third, -third
    (x1, y1, z1), (x2, y2, z2) = np.moveaxis(columns[..., :2], (3, 2), (0, 1))
    columns[..., 0, 2], columns[..., 1, 2] = y1 * z2 - z1 * y2, z1 * x2 - x1 * z2
    columns[..., 2, 2] = x1 * y2 - y1 * x2
    rotations = (toward @ columns).reshape(-1, 3, 3)
    return rotations, _positions(rotations, np.concatenate([rays, rays]), np.concatenate([sizes, sizes]))


def _turn_to(centre):
    """Rotations (M, 3, 3) that turn the optical axis to the directions (x, y, 1)."""
    n = len(centre)
    direction = np.concatenate([centre, np.ones((n, 1))], 1)
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    x, y, z = direction.T
    k = 1 / (1 + z)
    return np.stack([1 - x * x * k, -x * y * k, x, -x * y * k, 1 - y * y * k, y, -x, -y, z], 1).reshape(n, 3, 3)


def _positions(rotations, rays, sizes):
    """Least squares positions (B, 3) of squares of given rotation seen along rays (B, 4, 2)."""
    p = object_corners(1.0) * sizes[:, None, None] @ rotations.transpose(0, 2, 1)
    rows = np.zeros((len(p), 4, 2, 3))
    rows[..., 0, 0] = rows[..., 1, 1] = 1
    rows[..., 2] = -rays
    right = (rays * p[..., 2:] - p[..., :2]).reshape(-1, 8, 1)
    rows = rows.reshape(-1, 8, 3)
    turned = rows.transpose(0, 2, 1)
    return np.linalg.solve(turned @ rows, turned @ right)[:, :, 0]


def _refine(points, corners, camera, information, rotations, positions):
    """Solutions after one step of Gauss-Newton on the weighed reprojection, where it helps."""
    turned = points @ rotations.transpose(0, 2, 1)
    residual = _residual(turned, positions, corners, camera)
    jacobian = _jacobian(turned, positions, camera)
    jw = jacobian.transpose(0, 2, 1) @ information
    normal = jw @ jacobian
    normal *= 1 + DAMPING * np.eye(6)
    step = -np.linalg.solve(normal, jw @ residual[:, :, None])[:, :, 0]
    tried = [_turn(step[:, :3]) @ rotations, positions + step[:, 3:]]
    tried.append(_residual(points @ tried[0].transpose(0, 2, 1), tried[1], corners, camera))
    out = []
    for start, trial in zip(zip(rotations, positions, residual), zip(*tried)):
        weight = information[len(out)]
        (cost, (r, t, e)) = min(((e @ weight @ e if t[2] > 0 else np.inf, (r, t, e)) for r, t, e in (trial, start)),
                                key=lambda each: each[0])
        out.append(Solution(r, t, float(np.sqrt((e * e).mean() * 2)), float(cost)))
    return out


def _turn(vectors):
    """Rotation matrices (B, 3, 3) of rotation vectors (B, 3)."""
    angle = np.linalg.norm(vectors, axis=1)[:, None, None] + 1e-12
    x, y, z = (vectors / angle[:, 0]).T
    zero = np.zeros_like(x)
    k = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], 1).reshape(-1, 3, 3)
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * (k @ k)


def _residual(turned, positions, corners, camera):
    """(B, 8) px of squares whose points (B, 4, 3) are turned, at positions (B, 3)."""
    p = turned + positions[:, None]
    uv = p[..., :2] / p[..., 2:]
    return (uv * [camera.fx, camera.fy] + [camera.cx, camera.cy] - corners).reshape(len(p), 8)


def _jacobian(turned, positions, camera):
    """(B, 8, 6) of the residual by a small turn and a shift."""
    x, y, z = (turned + positions[:, None]).transpose(2, 0, 1)
    a, b, c = turned.transpose(2, 0, 1)
    u, v, fx, fy = x / z, y / z, camera.fx / z, camera.fy / z
    out = np.zeros(x.shape + (2, 6))
    out[..., 0, 0], out[..., 0, 1], out[..., 0, 2] = -fx * u * b, fx * (c + u * a), -fx * b
    out[..., 1, 0], out[..., 1, 1], out[..., 1, 2] = -fy * (c + v * b), fy * v * a, fy * a
    out[..., 0, 3], out[..., 0, 5] = fx, -fx * u
    out[..., 1, 4], out[..., 1, 5] = fy, -fy * v
    return out.reshape(len(x), 8, 6)


def ambiguity(solutions, degrees_of_freedom=DEGREES_OF_FREEDOM):
    """Return (share, ambiguous): how likely the second solution is against the first (0.5: both alike), and the flag.

    Solutions that differ by less than SAME_ROTATION are one and the same.
    """
    if len(solutions) < 2 or angle_between(solutions[0].rotation, solutions[1].rotation) < SAME_ROTATION:
        return 0.0, False
    difference = scaled_difference(solutions, degrees_of_freedom)
    return float(1 / (1 + np.exp(min(difference / 2, 50)))), bool(difference < AMBIGUOUS_CHI2)


def scaled_difference(solutions, degrees_of_freedom=DEGREES_OF_FREEDOM):
    """How much worse (chi2) the second solution is, less when even the first fits badly: not all is noise then."""
    return (solutions[1].chi2 - solutions[0].chi2) / max(1.0, solutions[0].chi2 / degrees_of_freedom)
