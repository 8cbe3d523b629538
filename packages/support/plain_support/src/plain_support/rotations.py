"""Rotations as matrices (3, 3), as quaternions x y z w, and as angles. Needs numpy."""
from __future__ import annotations

import math
from typing import Sequence

import numpy as np

from plain_support.arrays import Floats


def quaternion_from_matrix(rotation: Floats) -> Floats:
    """Return the quaternion x y z w (w >= 0) of a rotation matrix."""
    (a, b, c), (d, e, f), (g, h, i) = np.asarray(rotation).tolist()
    x, y, z, w = max(((1 + a - e - i, b + d, c + g, h - f), (b + d, 1 - a + e - i, f + h, c - g),
                      (c + g, f + h, 1 - a - e + i, d - b), (h - f, c - g, d - b, 1 + a + e + i)),
                     key=lambda q: sum(v * v for v in q))
    length = math.copysign(math.sqrt(x * x + y * y + z * z + w * w), w)
    return np.array([x / length, y / length, z / length, w / length])


def matrix_from_quaternion(quaternion: Sequence[float] | Floats) -> Floats:
    """Return the rotation matrix (3, 3) of a quaternion x y z w of any length above 0."""
    x, y, z, w = quaternion
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    x, y, z, w = x / norm, y / norm, z / norm, w / norm
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def matrix_from_rpy(roll: float, pitch: float, yaw: float) -> Floats:
    """Return the rotation matrix (3, 3) of angles [rad] about the fixed x, y and z axes, in this order (URDF, SDF)."""
    (cr, cp, cy), (sr, sp, sy) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    return np.array([[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                     [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                     [-sp, cp * sr, cp * cr]])


def rpy_from_matrix(rotation: Floats) -> tuple[float, float, float]:
    """Return roll, pitch, yaw [rad] of a rotation matrix (3, 3): the inverse of ``matrix_from_rpy``."""
    return (math.atan2(rotation[2, 1], rotation[2, 2]),
            math.atan2(-rotation[2, 0], math.hypot(rotation[2, 1], rotation[2, 2])),
            math.atan2(rotation[1, 0], rotation[0, 0]))


def angle_between(a: Floats, b: Floats) -> float:
    """Return the angle [rad] of the rotation from matrix ``a`` to matrix ``b``."""
    return math.acos(min(1.0, max(-1.0, (float(np.vdot(a, b)) - 1) / 2)))
