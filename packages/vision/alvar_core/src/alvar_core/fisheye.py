"""A wide lens: the equidistant (Kannala-Brandt) model of camera_calibration and cv2.fisheye.

A ray at the angle theta to the optical axis appears at a radius of theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 +
k4 theta^8) focal lengths. Ideal pixels exist only in front of the camera, for angles below 90 degrees.
"""
from __future__ import annotations

from functools import cached_property
from typing import Any

import cv2
import numpy as np

from alvar_core import native
from alvar_core.arrays import ArrayLike, Floats
from alvar_core.camera import Camera, CameraError


class FisheyeCamera(Camera):
    """Camera matrix (9 numbers) [px] and k1 k2 k3 k4; CameraError if unusable."""

    def __init__(self, matrix: ArrayLike, distortion: ArrayLike) -> None:
        super().__init__(matrix)
        values = np.asarray(distortion, np.float64).ravel()
        if values.size != 4 or not np.all(np.isfinite(values)):
            raise CameraError(f'fisheye distortion D is {values.tolist()}: 4 finite numbers (k1 k2 k3 k4) are needed')
        self.distortion, self.distorted = values, True

    @cached_property
    def lens(self) -> Any:
        """Return the lens for the compiled steps."""
        k1, k2, k3, k4 = self.distortion
        return native.steps.Lens(fx=self.fx, fy=self.fy, cx=self.cx, cy=self.cy, k1=k1, k2=k2, k3=k3, k4=k4,
                                 fisheye=True)

    def to_real(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Return the real pixel coordinates of ideal ones; ``x`` and ``y`` are two arrays of one shape."""
        x, y = (x - float(self.cx)) * float(1 / self.fx), (y - float(self.cy)) * float(1 / self.fy)
        radius = np.sqrt(x * x + y * y)
        theta = np.arctan(radius)
        t2 = theta * theta
        k1, k2, k3, k4 = (float(k) for k in self.distortion)
        drawn = theta * (1 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4))))
        scale = np.where(radius > 1e-9, drawn / np.maximum(radius, 1e-9), 1.0)
        return x * scale * float(self.fx) + float(self.cx), y * scale * float(self.fy) + float(self.cy)

    def to_ideal(self, points: ArrayLike) -> Floats:
        """Return the ideal pixel points (..., 2), float64, of real ones."""
        points = np.asarray(points, np.float64)
        flat = points.reshape(-1, 1, 2)
        ideal = cv2.fisheye.undistortPoints(flat, self.matrix, self.distortion, P=self.matrix)
        return np.asarray(ideal, np.float64).reshape(points.shape)
