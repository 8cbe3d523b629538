"""The Robotont's camera: its parameters and projections.

Optical frame: x right, y down, z forward; metres. Pixel (0, 0) is the centre of the top left one. The principal point
is (width / 2, height / 2), as in Gazebo's camera_info; the images are rendered with exactly these values.
"""
import math
from typing import List, NamedTuple, Sequence, Tuple

import numpy as np

from plain_support import InvalidInput

WIDTH, HEIGHT = 1280, 720  # [px]
HORIZONTAL_FOV = math.pi / 2.0  # [rad]
NEAR = 0.02  # [m] along z: nothing nearer is visible in any image
DEPTH_NEAR, DEPTH_FAR = 0.4, 5.0  # [m] along z: the real depth camera sees only what lies between
LOWEST_DEPTH, HIGHEST_DEPTH = 0.02, 100.0  # [m] that can be set instead
NARROWEST, WIDEST = 0.05, 2.8  # [rad] of the horizontal field of view
GAMMA, GAMMAS = 2.2, (1.0, 4.0)  # of most cameras, and the range: a pixel's value is light ** (1 / gamma)
DISTORTION = (0.0,) * 5  # k1 k2 p1 p2 k3 of plumb_bob
RECTIFICATION = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
SMALLEST, LARGEST = 16, 4096  # [px] of width and height


class CameraPose(NamedTuple):
    """The pose of the (level) camera in the world: x, y, z [m], yaw [rad] of its optical axis."""

    x: float
    y: float
    z: float
    yaw: float


class PinholeCamera:
    """A camera with square pixels and no distortion; raises InvalidInput for an impossible size or field of view.

    focal [px]; cx, cy [px]: the principal point; right (width,): x / z of each column; down (height,): y / z of each
    row.
    """

    def __init__(self, width: float = WIDTH, height: float = HEIGHT,
                 horizontal_fov: float = HORIZONTAL_FOV) -> None:
        for name, value in (('width', width), ('height', height)):
            if isinstance(value, bool) or value != int(value) or not SMALLEST <= value <= LARGEST:
                raise InvalidInput(f'{name} of the camera is {value!r}; it must be a whole number of '
                                   f'{SMALLEST} to {LARGEST} px')
        if not NARROWEST <= horizontal_fov <= WIDEST:
            raise InvalidInput(f'horizontal_fov of the camera is {horizontal_fov!r}; it must be {NARROWEST} to '
                               f'{WIDEST} rad')
        self.width, self.height, self.horizontal_fov = int(width), int(height), float(horizontal_fov)
        self.focal = 0.5 * width / math.tan(0.5 * horizontal_fov)
        self.cx, self.cy = 0.5 * width, 0.5 * height
        self.right = (np.arange(self.width) - self.cx) / self.focal
        self.down = (np.arange(self.height) - self.cy) / self.focal

    def matrix(self) -> List[float]:
        """Return K of camera_info, 9 numbers row by row [px]."""
        return [self.focal, 0.0, self.cx, 0.0, self.focal, self.cy, 0.0, 0.0, 1.0]

    def projection(self) -> List[float]:
        """Return P of camera_info, 12 numbers row by row [px]."""
        return [self.focal, 0.0, self.cx, 0.0, 0.0, self.focal, self.cy, 0.0, 0.0, 0.0, 1.0, 0.0]


def require_pose(pose: Sequence[float]) -> CameraPose:
    """Return (x, y, z, yaw) as a CameraPose; raise InvalidInput unless all numbers are finite."""
    x, y, z, yaw = map(float, pose)
    if not all(map(math.isfinite, (x, y, z, yaw))):
        raise InvalidInput(f'camera pose is {(x, y, z, yaw)!r}; x, y, z [m] and yaw [rad] must be finite')
    return CameraPose(x, y, z, yaw)


def require_range(near: float, far: float) -> Tuple[float, float]:
    """Return the range (near, far) [m] of a depth camera; raise InvalidInput if it is impossible."""
    if not LOWEST_DEPTH <= near < far <= HIGHEST_DEPTH:
        raise InvalidInput(f'the depth camera sees from {near!r} to {far!r} m; both must be {LOWEST_DEPTH:g} to '
                           f'{HIGHEST_DEPTH:g} m, and the first one the smaller one')
    return float(near), float(far)


def require_gamma(gamma: float) -> float:
    """Return the exponent of a camera's response; raise InvalidInput if it is impossible."""
    low, high = GAMMAS
    if not low <= gamma <= high:
        raise InvalidInput(f'gamma of the camera is {gamma!r}; it must be {low:g} to {high:g}')
    return float(gamma)
