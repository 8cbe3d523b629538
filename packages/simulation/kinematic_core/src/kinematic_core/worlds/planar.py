"""Poses and velocities in the plane, and the exact motion that a constant velocity makes."""
import math
from typing import NamedTuple

from kinematic_core.worlds.angles import wrap_angle


class Pose2D(NamedTuple):
    """The pose of a body in the frame that it moves in: x, y [m], yaw [rad], counter-clockwise from +x."""

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0


class Twist2D(NamedTuple):
    """The velocity of a body in its own frame, with the fields of a geometry_msgs/Twist that matter in the plane.

    linear_x [m/s] forward, linear_y [m/s] to the left, angular_z [rad/s] counter-clockwise.
    """

    linear_x: float = 0.0
    linear_y: float = 0.0
    angular_z: float = 0.0


ORIGIN = Pose2D()
STILL = Twist2D()


def compose(frame: Pose2D, pose: Pose2D) -> Pose2D:
    """Return a pose, given in ``frame``, in the frame that ``frame`` is given in."""
    cos, sin = math.cos(frame.yaw), math.sin(frame.yaw)
    return Pose2D(frame.x + cos * pose.x - sin * pose.y, frame.y + sin * pose.x + cos * pose.y,
                  wrap_angle(frame.yaw + pose.yaw))


def relative(pose: Pose2D, frame: Pose2D) -> Pose2D:
    """Return a pose in ``frame``; both are given in the same frame."""
    dx, dy = pose.x - frame.x, pose.y - frame.y
    cos, sin = math.cos(frame.yaw), math.sin(frame.yaw)
    return Pose2D(cos * dx + sin * dy, cos * dy - sin * dx, wrap_angle(pose.yaw - frame.yaw))


def advance(pose: Pose2D, twist: Twist2D, dt: float) -> Pose2D:
    """Return the pose after ``dt`` [s] of a constant twist: an exact arc; yaw in [-pi, pi).

    The chord of the arc points half the turned angle h away from the first heading and is sin(h) / h of its length.
    """
    half = 0.5 * twist.angular_z * dt
    middle = pose.yaw + half
    along = chord_ratio(half) * dt
    cos, sin = math.cos(middle) * along, math.sin(middle) * along
    return Pose2D(pose.x + cos * twist.linear_x - sin * twist.linear_y,
                  pose.y + sin * twist.linear_x + cos * twist.linear_y, wrap_angle(middle + half))


def chord_ratio(half: float) -> float:
    """Return sin(h) / h: the length of a chord divided by that of its arc, which turns by 2 h [rad]."""
    return math.sin(half) / half if half else 1.0


def mean_twist(pose: Pose2D, later: Pose2D, angular_z: float, dt: float) -> Twist2D:
    """Return the constant twist that leads from ``pose`` to ``later`` in ``dt`` [s] while turning at ``angular_z``.

    ``angular_z`` [rad/s] is given because the poses do not show whole turns. It must not be a multiple of 2 pi / dt,
    where the chord vanishes.
    """
    half = 0.5 * angular_z * dt
    middle, along = pose.yaw + half, chord_ratio(half) * dt
    cos, sin = math.cos(middle), math.sin(middle)
    x, y = (later.x - pose.x) / along, (later.y - pose.y) / along
    return Twist2D(cos * x + sin * y, cos * y - sin * x, angular_z)
