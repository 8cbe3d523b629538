"""A drive through the minimaze without ROS: odometry, laser scans, and the true poses."""
import math
from typing import NamedTuple

import numpy as np

from kinematic_core.worlds.frames import LIDAR_X, LIDAR_Z, ahead
from kinematic_core.worlds.planar import Pose2D
from kinematic_core.worlds.rays import FIRST_ANGLE, LAST_ANGLE, RAYS, LaserScanner
from kinematic_core.worlds.robot_world import RobotWorld
from navigation_core.poses import Pose
from sim_scene.worlds import load_world
from unit_support import REPOSITORY

WORLDS = str(REPOSITORY / 'packages' / 'robotont' / 'robotont_gazebo' / 'worlds')
START = Pose2D(-2.0, 0.0, 0.0)
TOUR = ((-2, 2), (0, 2), (0, -2), (-2, -2), (0, -2), (2, -2), (2, 2), (2, -2), (0, -2), (0, 2), (-2, 2), (-2, 0))
SPEED, TURN = 0.3, 0.4  # [m/s], [rad/s]
COMMAND_STEPS, SCAN_STEPS = 12, 24  # of 120 a second
CAMERA = slice(RAYS * 3 // 8, RAYS * 5 // 8)  # the beams of 90 degrees ahead
CAMERA_NEAREST, CAMERA_FARTHEST = 0.4, 5.0  # [m]
INCREMENT = (LAST_ANGLE - FIRST_ANGLE) / (RAYS - 1)
MOUNT = Pose(LIDAR_X, 0.0, 0.0)


class Moment(NamedTuple):
    """One scan of a drive: time [s], true pose, odometry's pose, ranges [m]."""

    time: float
    truth: Pose
    odometry: Pose
    ranges: np.ndarray


def plan():
    """Return the FloorPlan of the minimaze."""
    return load_world('minimaze', WORLDS)[0]


def walls():
    """Return the walls that the laser scanner sees, as polygons."""
    return plan().outlines(LIDAR_Z)


def drive(noise, slip, seed, tour=TOUR):
    """Return the Moments of a drive with the odometry's noise [m] and slip, as robotont_gazebo's ~odom_*."""
    floor = plan()
    world = RobotWorld(floor, START, slip=slip, noise=noise, seed=seed)
    scanner = LaserScanner(floor, LIDAR_Z, seed=seed)
    goals, moments = list(tour), []
    while goals:
        pose = world.pose
        if world.steps % COMMAND_STEPS == 0:
            x, y = goals[0][0] - pose.x, goals[0][1] - pose.y
            if math.hypot(x, y) < 0.1:
                goals.pop(0)
            speed, angle = min(SPEED, 2.0 * math.hypot(x, y)), math.atan2(y, x) - pose.yaw
            world.command(speed * math.cos(angle), speed * math.sin(angle), TURN * math.cos(world.time / 17.0))
        if world.steps % SCAN_STEPS == 0:
            moments.append(Moment(world.time, Pose(*pose), Pose(*world.odometry.pose),
                                  scanner.scan(*ahead(pose, LIDAR_X), pose.yaw)))
        world.step()
    return moments
