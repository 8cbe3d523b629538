"""The frames of a Robotont and the positions of its sensors, as in robotont_description."""
import math
from typing import NamedTuple, Tuple

from kinematic_core.worlds.omni import WHEELS
from kinematic_core.worlds.planar import Pose2D

BASE_HEIGHT = 0.013  # [m] of base_link above base_footprint, which is on the floor
AXLE_HEIGHT = 0.021  # [m] of the wheels' middles above base_link
CAMERA_X, CAMERA_Z = -0.115, BASE_HEIGHT + 0.2025  # [m] of camera_link from base_footprint
LIDAR_X, LIDAR_Z = -0.01, BASE_HEIGHT + 0.135  # [m] of hokuyo_link from base_footprint


class Frames(NamedTuple):
    """Names of frames, each with the prefix of a namespace, e.g. ``robot1/``."""

    odom: str
    footprint: str
    base: str
    camera: str  # optical: z forward, x right, y down
    lidar: str
    wheels: Tuple[str, ...]  # links, in the order of omni.WHEELS
    joints: Tuple[str, ...]  # of the wheels


def frames(prefix: str) -> Frames:
    """Return the Frames with a prefix, which may be empty."""
    return Frames(f'{prefix}odom', f'{prefix}base_footprint', f'{prefix}base_link',
                  f'{prefix}camera_depth_optical_frame', f'{prefix}hokuyo_link',
                  tuple(f'{prefix}rim_{wheel}_link' for wheel in WHEELS),
                  tuple(f'{prefix}rim_{wheel}_joint' for wheel in WHEELS))


def ahead(pose: Pose2D, distance: float) -> Tuple[float, float]:
    """Return the point (x, y) [m] at ``distance`` [m] ahead of (if negative: behind) a robot at ``pose``."""
    return pose.x + distance * math.cos(pose.yaw), pose.y + distance * math.sin(pose.yaw)
