"""Poses in the plane as frames: metres, radians. No ROS."""
import math

from kinematic_core.worlds.angles import wrap_angle
from kinematic_core.worlds.planar import Pose2D


def compose(frame: Pose2D, pose: Pose2D) -> Pose2D:
    """Convert a pose given in ``frame`` to the frame in which ``frame`` is given."""
    cos, sin = math.cos(frame.yaw), math.sin(frame.yaw)
    return Pose2D(frame.x + cos * pose.x - sin * pose.y, frame.y + sin * pose.x + cos * pose.y,
                  wrap_angle(frame.yaw + pose.yaw))


def inverse(pose: Pose2D) -> Pose2D:
    """Return the pose of the outer frame in the frame ``pose``."""
    cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
    return Pose2D(-cos * pose.x - sin * pose.y, sin * pose.x - cos * pose.y, wrap_angle(-pose.yaw))
