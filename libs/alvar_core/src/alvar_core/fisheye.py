"""A wide lens: the equidistant (Kannala-Brandt) model, as camera_calibration writes it and cv2.fisheye has it.

The angle theta of a ray to the optical axis is drawn at the radius theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 +
k4 theta^8) focal lengths. Ideal pixels exist in front of the camera only, below 90 degrees.
"""
from __future__ import annotations

import cv2
import numpy as np

from alvar_core.arrays import ArrayLike, Floats
from alvar_core.camera import Camera, CameraError


class FisheyeCamera(Camera):
    """Camera matrix (9 numbers, pixels) and k1 k2 k3 k4; CameraError if unusable."""

    def __init__(self, matrix: ArrayLike, distortion: ArrayLike) -> None:
        super().__init__(matrix)
        values = np.asarray(distortion, np.float64).ravel()
        if values.size != 4 or not np.all(np.isfinite(values)):
            raise CameraError(f'fisheye distortion D is {values.tolist()}: 4 finite numbers (k1 k2 k3 k4) are needed')
        self.distortion, self.distorted = values, True

    def to_real(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Ideal pixel coordinates (two arrays of one shape) to real ones."""
        x, y = (x - float(self.cx)) * float(1 / self.fx), (y - float(self.cy)) * float(1 / self.fy)
        radius = np.sqrt(x * x + y * y)
        theta = np.arctan(radius)
        t2 = theta * theta
        k1, k2, k3, k4 = (float(k) for k in self.distortion)
        drawn = theta * (1 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4))))
        scale = np.where(radius > 1e-9, drawn / np.maximum(radius, 1e-9), 1.0)
        return x * scale * float(self.fx) + float(self.cx), y * scale * float(self.fy) + float(self.cy)

    def to_ideal(self, points: ArrayLike) -> Floats:
        """Real pixel points (..., 2) to ideal ones, float64."""
        points = np.asarray(points, np.float64)
        flat = points.reshape(-1, 1, 2)
        ideal = cv2.fisheye.undistortPoints(flat, self.matrix, self.distortion, P=self.matrix)
        return np.asarray(ideal, np.float64).reshape(points.shape)
