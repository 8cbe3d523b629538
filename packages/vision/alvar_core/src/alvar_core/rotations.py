"""Rotations: those of plain_support.rotations, and that of a marker that faces the camera."""
from __future__ import annotations

import cv2
import numpy as np

from alvar_core.arrays import Floats
from plain_support.rotations import angle_between, matrix_from_quaternion, matrix_from_rpy, quaternion_from_matrix

__all__ = ['angle_between', 'facing', 'matrix_from_quaternion', 'matrix_from_rpy', 'quaternion_from_matrix']


def facing(tilt: float, azimuth: float, roll: float) -> Floats:
    """Return the rotation (3, 3) of a marker that faces the camera, rolled about the optical axis, then tilted [rad].

    The axis of the tilt lies in the image plane, in the direction ``azimuth`` [rad].
    """
    toward = np.diag([1.0, -1.0, -1.0])
    axis = np.array([np.cos(azimuth), np.sin(azimuth), 0.0]) * tilt
    return cv2.Rodrigues(axis)[0] @ cv2.Rodrigues(np.array([0.0, 0.0, roll]))[0] @ toward
