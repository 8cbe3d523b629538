"""Pose of a square marker from its corners: both solutions of the planar ambiguity, weighed.

Marker frame: origin in the centre of the black square; looking at the marker as drawn: x right, y up, z out of it.
Camera frame: optical (x right, y down, z forward).  Lengths in metres, angles in radians.
"""
from dataclasses import dataclass

import numpy as np

from alvar_core import homography

AMBIGUOUS_CHI2 = 16.0
DEGREES_OF_FREEDOM = 2  # eight corner coordinates less six of a pose
SAME_ROTATION = np.radians(3.0)
DEFAULT_CORNER_SIGMA = 0.2  # px
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
    return float(np.arccos(np.clip((np.trace(a.T @ b) - 1) / 2, -1, 1)))


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
    good = np.isfinite(rotations).all((1, 2)) & np.isfinite(positions).all(1) & (positions[:, 2] > 0)
    owner = np.tile(np.arange(len(corners)), 2)[good]
    if len(owner):
        points = np.array([object_corners(sizes[m]) for m in owner])
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
    h = homography.from_square(rays, 0.5)
    h = h * [1.0, -1.0, 1.0]  # marker y is up
    centre = h[:, :2, 2]
    jacobian = (h[:, :2, :2] - centre[:, :, None] * h[:, 2:, :2]) / sizes[:, None, None]
    toward = _turn_to(centre)
    basis = toward[:, :2, :2] - centre[:, :, None] * toward[:, 2:, :2]
    a = np.linalg.solve(basis, jacobian)
    square = (a * a).sum((1, 2))
    det = a[:, 0, 0] * a[:, 1, 1] - a[:, 0, 1] * a[:, 1, 0]
    scale = np.sqrt(0.5 * (square + np.sqrt(np.maximum(square ** 2 - 4 * det ** 2, 0))))
    r = a / scale[:, None, None]
    third = np.sqrt(np.maximum(1 - (r * r).sum(1), 0))
    mixed = -(r[:, :, 0] * r[:, :, 1]).sum(1)
    third[:, 1] = np.where(mixed < 0, -third[:, 1], third[:, 1])
    rotations = []
    for sign in (1.0, -1.0):
        columns = np.concatenate([r, sign * third[:, None]], 1)
        last = np.cross(columns[:, :, 0], columns[:, :, 1])
        rotations.append(toward @ np.concatenate([columns, last[:, :, None]], 2))
    rotations = np.concatenate(rotations)
    return rotations, _positions(rotations, np.tile(rays, (2, 1, 1)), np.tile(sizes, 2))


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


def _refine(points, corners, camera, information, rotations, positions, iterations=2):
    best = None
    damping = np.full(len(rotations), 1e-4)
    trial_r, trial_t = rotations, positions
    for i in range(iterations):
        residual, jacobian = _residual(points, corners, camera, trial_r, trial_t)
        cost = np.einsum('bi,bij,bj->b', residual, information, residual)
        cost = np.where((trial_t[:, 2] > 0) & np.isfinite(cost), cost, np.inf)
        trial = [trial_r, trial_t, cost, residual, jacobian]
        if best is None:
            best = trial
        else:
            better = cost < best[2]
            damping = np.where(better, damping * 0.2, damping * 10)
            best = [np.where(better.reshape((-1,) + (1,) * (new.ndim - 1)), new, old) for new, old in zip(trial, best)]
        if i == iterations - 1:
            break
        jw = best[4].transpose(0, 2, 1) @ information
        normal = jw @ best[4]
        normal = normal + np.eye(6) * (np.einsum('bii->bi', normal) * damping[:, None])[:, None]
        step = -np.linalg.solve(normal, jw @ best[3][:, :, None])[:, :, 0]
        trial_r = _turn(step[:, :3]) @ best[0]
        trial_t = best[1] + step[:, 3:]
    return [Solution(r, t, float(np.sqrt((e * e).mean() * 2)), float(c)) for r, t, c, e in zip(*best[:4])]


def _turn(vectors):
    """Rotation matrices (B, 3, 3) of rotation vectors (B, 3)."""
    angle = np.linalg.norm(vectors, axis=1)[:, None, None] + 1e-12
    x, y, z = (vectors / angle[:, 0]).T
    zero = np.zeros_like(x)
    k = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], 1).reshape(-1, 3, 3)
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * (k @ k)


def _residual(points, corners, camera, rotations, positions):
    turned = points @ rotations.transpose(0, 2, 1)
    p = turned + positions[:, None]
    inverse = 1 / p[..., 2]
    uv = p[..., :2] * inverse[..., None]
    focal = [camera.fx, camera.fy]
    residual = (uv * focal + [camera.cx, camera.cy] - corners).reshape(len(p), 8)
    jp = np.zeros(p.shape[:2] + (2, 3))
    jp[..., 0, 0] = camera.fx * inverse
    jp[..., 1, 1] = camera.fy * inverse
    jp[..., 0, 2] = -camera.fx * uv[..., 0] * inverse
    jp[..., 1, 2] = -camera.fy * uv[..., 1] * inverse
    x, y, z = turned[..., 0], turned[..., 1], turned[..., 2]
    cross = np.zeros(p.shape[:2] + (3, 3))
    cross[..., 0, 1], cross[..., 0, 2] = z, -y
    cross[..., 1, 0], cross[..., 1, 2] = -z, x
    cross[..., 2, 0], cross[..., 2, 1] = y, -x
    jacobian = np.concatenate([jp @ cross, jp], -1).reshape(len(p), 8, 6)
    return residual, jacobian


def ambiguity(solutions):
    """Return (share, ambiguous): how likely the second solution is against the first (0.5: both alike), and the flag.

    Solutions that differ by less than SAME_ROTATION are one and the same.
    """
    if len(solutions) < 2 or angle_between(solutions[0].rotation, solutions[1].rotation) < SAME_ROTATION:
        return 0.0, False
    difference = scaled_difference(solutions)
    return float(1 / (1 + np.exp(min(difference / 2, 50)))), bool(difference < AMBIGUOUS_CHI2)


def scaled_difference(solutions):
    """How much worse (chi2) the second solution is, less when even the first fits badly: not all is noise then."""
    return (solutions[1].chi2 - solutions[0].chi2) / max(1.0, solutions[0].chi2 / DEGREES_OF_FREEDOM)
