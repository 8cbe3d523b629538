"""Poses and twists in the plane, and the exact motion that a constant twist makes."""
import math
from typing import NamedTuple

from kinematic_core.angles import wrap_angle


class Pose(NamedTuple):
    """Where a body is in the frame that it moves in: x, y [m], yaw [rad], counter-clockwise from +x."""

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0


class Twist(NamedTuple):
    """How fast a body moves, in its own frame: x forward and y to the left [m/s], turn [rad/s] counter-clockwise."""

    x: float = 0.0
    y: float = 0.0
    turn: float = 0.0


ORIGIN = Pose()
STILL = Twist()


def advance(pose, twist, dt):
    """Return the Pose after ``dt`` [s] of a constant twist: an exact arc; yaw in [-pi, pi).

    The chord of the arc points half the turned angle h away from the first heading and is sin(h) / h of its length.
    """
    half = 0.5 * twist.turn * dt
    middle = pose.yaw + half
    along = chord(half) * dt
    cos, sin = math.cos(middle) * along, math.sin(middle) * along
    return Pose(pose.x + cos * twist.x - sin * twist.y, pose.y + sin * twist.x + cos * twist.y,
                wrap_angle(middle + half))


def chord(half):
    """Return sin(h) / h, the length of a chord over its arc's, which turns by 2 h [rad]."""
    return math.sin(half) / half if half else 1.0


def mean_twist(pose, later, turn, dt):
    """Return the constant Twist that leads from one Pose to another within ``dt`` [s] while turning at ``turn``.

    ``turn`` [rad/s] is given because the poses do not show whole turns. It must not make the chord vanish, which a
    turn by a multiple of 2 pi within ``dt`` does.
    """
    half = 0.5 * turn * dt
    middle, along = pose.yaw + half, chord(half) * dt
    cos, sin = math.cos(middle), math.sin(middle)
    x, y = (later.x - pose.x) / along, (later.y - pose.y) / along
    return Twist(cos * x + sin * y, cos * y - sin * x, turn)
