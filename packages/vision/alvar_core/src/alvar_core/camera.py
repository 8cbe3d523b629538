"""Map ideal (undistorted) pixels of a camera to real ones and back, with plumb_bob, rational or equidistant distortion.

Ideal pixels are those of a camera with the same matrix and no distortion: u = fx x / z + cx. Pixel (0, 0) is the
centre of the top left pixel.
"""
from __future__ import annotations

from functools import cached_property
from typing import Any

import cv2
import numpy as np

from alvar_core import native
from alvar_core.arrays import ArrayLike, Floats

MAX_STRETCH = 3  # wide lenses with a plumb_bob model have up to 1.3 half-way to the edge


class CameraError(ValueError):
    """A camera matrix or distortion cannot be used."""


class Camera:
    """Camera matrix (9 numbers) [px] and distortion (k1 k2 p1 p2 [k3 [k4 k5 k6]]); CameraError if unusable.

    ``size`` (width, height) [px], if given, is the size of its images; others are refused.
    """

    def __init__(self, matrix: ArrayLike, distortion: ArrayLike | None = None,
                 size: tuple[int, int] | None = None) -> None:
        self.size = None if size is None else (int(size[0]), int(size[1]))
        self.matrix = _checked_matrix(matrix)
        self.distortion = _checked_distortion(distortion)
        self.distorted = bool(np.any(self.distortion))
        self.fx, self.fy, self.cx, self.cy = self.matrix[[0, 1, 0, 1], [0, 1, 2, 2]]
        self.focal, self.centre = self.matrix[[0, 1], [0, 1]], self.matrix[:2, 2]
        if self.distorted:
            self._check_distortion()

    def _check_distortion(self) -> None:
        """Raise CameraError if pixels half-way to the image's edges are far from ideal ones: no lens does that."""
        half = np.array(self.size) / 2 if self.size else np.maximum(self.centre, 1)
        # of an image that is much higher than wide, not where no lens sees
        away = np.minimum(half, self.focal) / 2 * np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
        with np.errstate(all='ignore'):
            ideal = self.to_ideal(self.centre + away) - self.centre
            again = np.stack(self.to_real(*(ideal + self.centre).T), 1) - self.centre
            stretch = np.linalg.norm(ideal, axis=1) / np.linalg.norm(away, axis=1)
        if not (np.abs(again - away).max() < 1 and 1 / MAX_STRETCH < stretch.min() <= stretch.max() < MAX_STRETCH):
            raise CameraError(f'distortion D is {self.distortion.tolist()}: half-way to the edge of the image it moves '
                              f'pixels by a factor of more than {MAX_STRETCH}, or nowhere; no lens has this. Is the '
                              'camera calibrated?')

    @cached_property
    def lens(self) -> Any:
        """Return the lens for the compiled steps, which do not use the method ``to_real``."""
        k1, k2, p1, p2, k3, k4, k5, k6 = self.distortion
        return native.steps.Lens(fx=self.fx, fy=self.fy, cx=self.cx, cy=self.cy,
                                 k1=k1, k2=k2, p1=p1, p2=p2, k3=k3, k4=k4, k5=k5, k6=k6)

    def to_real(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Return the real pixel coordinates of ideal ones; ``x`` and ``y`` are two arrays of one shape."""
        if not self.distorted:
            return x, y
        k1, k2, p1, p2, k3, k4, k5, k6 = (float(k) for k in self.distortion)
        x = (x - float(self.cx)) * float(1 / self.fx)
        y = (y - float(self.cy)) * float(1 / self.fy)
        xx, yy, xy = x * x, y * y, x * y
        r2 = xx + yy
        scale = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        if k4 or k5 or k6:
            scale = scale / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)))
        real_x = x * scale + 2 * p1 * xy + p2 * (r2 + 2 * xx)
        real_y = y * scale + p1 * (r2 + 2 * yy) + 2 * p2 * xy
        return real_x * float(self.fx) + float(self.cx), real_y * float(self.fy) + float(self.cy)

    def to_ideal(self, points: ArrayLike) -> Floats:
        """Return the ideal pixel points (..., 2), float64, of real ones."""
        points = np.asarray(points, np.float64)
        if not self.distorted:
            return points.copy()
        flat = points.reshape(-1, 1, 2)
        ideal = cv2.undistortPoints(flat, self.matrix, self.distortion, P=self.matrix)
        return np.asarray(ideal, np.float64).reshape(points.shape)

    def to_rays(self, ideal: ArrayLike) -> Floats:
        """Return the rays (..., 2), x/z and y/z, of ideal pixel points (..., 2)."""
        return (np.asarray(ideal) - self.centre) / self.focal


def default_camera(width: int = 640, height: int = 480, distorted: bool = False) -> Camera:
    """Return a Camera like that of a webcam, 60 degrees wide, with slight barrel distortion if ``distorted``."""
    focal = 0.82 * width
    return Camera([focal, 0, width / 2 - 0.5, 0, focal, height / 2 - 0.5, 0, 0, 1],
                  [-0.15, 0.04, 0.001, -0.0008, 0.0] if distorted else None)


def _numbers(values: ArrayLike, what: str) -> Floats:
    try:
        return np.asarray(values, np.float64).ravel()
    except (TypeError, ValueError):
        raise CameraError(f'{what} is {values!r}: numbers are needed') from None


def _checked_matrix(matrix: ArrayLike) -> Floats:
    values = _numbers(matrix, 'camera matrix K')
    if values.size != 9:
        raise CameraError(f'camera matrix K has {values.size} numbers; 9 are needed')
    matrix = values.reshape(3, 3)
    if not np.all(np.isfinite(matrix)) or matrix[0, 0] <= 0 or matrix[1, 1] <= 0 \
            or not np.allclose(matrix[2], [0, 0, 1]):
        raise CameraError(f'camera matrix K is {matrix.ravel().tolist()}: fx and fy must be above 0, the last row '
                          'must be 0 0 1, and all must be finite; is the camera calibrated?')
    return matrix


def _checked_distortion(distortion: ArrayLike | None) -> Floats:
    values = np.zeros(0) if distortion is None else _numbers(distortion, 'distortion D')
    if values.size > 8 or not np.all(np.isfinite(values)):
        raise CameraError(f'distortion D is {values.tolist()}: up to 8 finite numbers (k1 k2 p1 p2 k3 k4 k5 k6) '
                          'are needed')
    return np.concatenate([values, np.zeros(8 - values.size)])


class FisheyeCamera(Camera):
    """A wide lens: the equidistant (Kannala-Brandt) model of camera_calibration and cv2.fisheye.

    Camera matrix (9 numbers) [px] and k1 k2 k3 k4; CameraError if unusable. A ray at the angle theta to the optical
    axis appears at a radius of theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8) focal lengths. Ideal
    pixels exist only in front of the camera, for angles below 90 degrees.
    """

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
