"""The depth camera and the marker tracker of a Robotont, computed from its world. Without ROS, and without images.

Camera and scan are those of robotont_gazebo and robotont_laserscan_to_distance; no image is rendered, because robots
are graded faster than that.
"""
import math
from typing import Dict, Tuple

import numpy as np

from kinematic_core.worlds.camera import DEPTH_NEAR, HORIZONTAL_FOV, PinholeCamera
from kinematic_core.worlds.floor_plan import FloorPlan
from kinematic_core.worlds.frames import CAMERA_X, CAMERA_Z, ahead
from kinematic_core.worlds.planar import Pose2D
from kinematic_core.worlds.rays import RayCaster
from kinematic_core.worlds.sectors import Sectors, floor_depth, split

RAYS = 181  # half a degree apart
FLOOR = floor_depth(CAMERA_Z, PinholeCamera().focal)  # [m]
NEAREST_MARKER = 0.2  # [m] ahead
MIN_FRONT = 0.3  # cosine of the angle from which a marker is seen, as the tracker sees it: up to 72 degrees
BESIDE = 0.1  # [m] that a marker's own board or wall may be before its middle


class DistanceSensor:
    """The message LaserScanSplit: the nearest range and the mean of three sectors of 30 degrees each."""

    def __init__(self, plan: FloorPlan) -> None:
        half = HORIZONTAL_FOV / 2.0
        angles = np.linspace(-half, half, RAYS)  # from the right to the left
        self._cosines = np.cos(angles)
        self._caster = RayCaster(plan, CAMERA_Z, angles)

    def measure(self, pose: Pose2D) -> Sectors:
        """Return the Sectors [m] for a robot at ``pose``: NaN for objects nearer than the camera can see."""
        ranges = self._caster.ranges(*ahead(pose, CAMERA_X), pose.yaw)
        depths = np.minimum(ranges * self._cosines, FLOOR)
        depths[depths <= DEPTH_NEAR] = np.nan
        return split((depths / self._cosines).tolist())


def markers(plan: FloorPlan, time: float, pose: Pose2D) -> Dict[int, Tuple[float, float, float]]:
    """Return {id: (ahead, left, up) [m] of the camera} of all markers, ``time`` [s] after the start of the world."""
    x, y = ahead(pose, CAMERA_X)
    cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
    return {panel.marker_id: (cos * (panel.x - x) + sin * (panel.y - y), cos * (panel.y - y) - sin * (panel.x - x),
                              panel.bottom + panel.size / 2.0 - CAMERA_Z) for panel in plan.at(time).panels}


def in_view(position: Tuple[float, float, float]) -> bool:
    """Return whether the camera's image contains a position (ahead, left, up) [m]."""
    return position[0] > NEAREST_MARKER and abs(position[1]) < position[0] * math.tan(HORIZONTAL_FOV / 2.0)


class MarkerCamera:
    """The markers of a world that the camera sees: in its image, from the front, and not behind something."""

    def __init__(self, plan: FloorPlan) -> None:
        self._plan, self._ray = plan, RayCaster(plan, CAMERA_Z, np.zeros(1))

    def seen(self, time: float, pose: Pose2D) -> Dict[int, Tuple[float, float, float]]:
        """Return {id: (ahead, left, up) [m] of the camera}, ``time`` [s] after the start of the world."""
        x, y = ahead(pose, CAMERA_X)
        panels = {panel.marker_id: panel for panel in self._plan.at(time).panels}
        found = {}
        for marker, position in markers(self._plan, time, pose).items():
            panel = panels[marker]
            direction = math.atan2(panel.y - y, panel.x - x)
            distance = math.hypot(panel.x - x, panel.y - y)
            free = float(self._ray.ranges(x, y, direction)[0]) > distance - BESIDE
            if in_view(position) and free and math.cos(direction - panel.yaw) > MIN_FRONT:
                found[marker] = position
        return found
