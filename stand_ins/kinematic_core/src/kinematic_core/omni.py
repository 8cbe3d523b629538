"""The Robotont's base: three omni wheels, what they can do, and what they measure.

Frame base_link: x forward, y to the left. Wheels in the order of WHEELS; a wheel's speed is positive when it drives
the robot round counter-clockwise, which is the direction of its joint in the URDF (axis towards the middle).
"""
import math
from typing import NamedTuple

from kinematic_core.planar import ORIGIN, STILL, Twist, advance

WHEELS = ('back', 'right', 'left')
WHEEL_ANGLES = (math.pi, -math.pi / 3.0, math.pi / 3.0)  # [rad] where the wheels are, seen from the middle
WHEEL_RADIUS = 0.035  # [m]
WHEEL_DISTANCE = 0.146  # [m] of each wheel from the middle
_TANGENTS = tuple((-math.sin(angle), math.cos(angle)) for angle in WHEEL_ANGLES)  # where a wheel pushes
(_BACK_X, _BACK_Y), (_RIGHT_X, _RIGHT_Y), (_LEFT_X, _LEFT_Y) = _TANGENTS


def wheel_speeds(twist):
    """Return the speeds of the three wheels [rad/s] for a body Twist; angles [rad] for a way instead of a speed."""
    x, y, turn = twist
    turn *= WHEEL_DISTANCE
    return ((_BACK_X * x + _BACK_Y * y + turn) / WHEEL_RADIUS,
            (_RIGHT_X * x + _RIGHT_Y * y + turn) / WHEEL_RADIUS,
            (_LEFT_X * x + _LEFT_Y * y + turn) / WHEEL_RADIUS)


def body_twist(speeds):
    """Return the body Twist that three wheel speeds [rad/s] make: the inverse of ``wheel_speeds``."""
    scale = 2.0 / 3.0 * WHEEL_RADIUS
    return Twist(scale * sum(speed * tangent[0] for speed, tangent in zip(speeds, _TANGENTS)),
                 scale * sum(speed * tangent[1] for speed, tangent in zip(speeds, _TANGENTS)),
                 sum(speeds) * WHEEL_RADIUS / (3.0 * WHEEL_DISTANCE))


class Limits(NamedTuple):
    """What base and wheels can do at most; infinite, as in Gazebo, where nothing is given."""

    speed: float = math.inf  # [m/s] of the middle, in any direction
    turn_speed: float = math.inf  # [rad/s]
    wheel_speed: float = math.inf  # [rad/s]
    acceleration: float = math.inf  # [m/s^2]
    turn_acceleration: float = math.inf  # [rad/s^2]
    wheel_acceleration: float = math.inf  # [rad/s^2]

    def limited(self, twist):
        """Return the twist, slowed down as a whole to what is allowed: the robot stays on the path asked for."""
        return _scaled(twist, self.speed, self.turn_speed, self.wheel_speed)

    def approached(self, twist, target, dt):
        """Return the twist after ``dt`` [s] on the straight way from ``twist`` to ``target``."""
        change = Twist(target.x - twist.x, target.y - twist.y, target.turn - twist.turn)
        allowed = _scaled(change, self.acceleration * dt, self.turn_acceleration * dt, self.wheel_acceleration * dt)
        if allowed is change:
            return target
        return Twist(twist.x + allowed.x, twist.y + allowed.y, twist.turn + allowed.turn)


UNLIMITED = Limits()


def _scaled(twist, linear, angular, wheel):
    """Return the twist itself when all is allowed, else the longest allowed part of it."""
    scale = 1.0
    speed, turn, fastest = math.hypot(twist.x, twist.y), abs(twist.turn), max(map(abs, wheel_speeds(twist)))
    for value, limit in ((speed, linear), (turn, angular), (fastest, wheel)):
        if value > limit:
            scale = min(scale, limit / value)
    return twist if scale == 1.0 else Twist(twist.x * scale, twist.y * scale, twist.turn * scale)


class Odometry:
    """What the robot believes from its wheels: ``pose``, ``twist``, ``distance`` [m] rolled since it began.

    ``slip`` is the share of the wheels' turning that does not move the robot: with 0.1 it believes to have come 1 / 0.9
    times as far as it has. ``noise`` [m] is the standard deviation of each wheel's way after one metre; it grows with
    the square root of the way, and so does not depend on the length of the steps.
    """

    def __init__(self, pose=ORIGIN, slip=0.0, noise=0.0, random=None):
        """Begin at ``pose``; ``random`` is a random.Random, needed with noise."""
        self.slip, self.noise = slip, noise
        self._random = random
        self.exact = not slip and not noise
        self.start(pose)

    def start(self, pose):
        """Begin anew at a pose."""
        self.pose, self.twist, self.distance = pose, STILL, 0.0

    def roll(self, twist, dt):
        """Count ``dt`` [s] in which the robot really moved with the Twist."""
        speeds = [speed / (1.0 - self.slip) for speed in wheel_speeds(twist)]
        if self.noise:
            ways = [abs(speed) * WHEEL_RADIUS * dt for speed in speeds]
            speeds = [speed + self._random.gauss(0.0, 1.0) * self.noise * math.sqrt(way) / (WHEEL_RADIUS * dt)
                      for speed, way in zip(speeds, ways)]
        self.twist = body_twist(speeds)
        self.pose = advance(self.pose, self.twist, dt)
        self.distance += math.hypot(self.twist.x, self.twist.y) * dt

    def follow(self, pose, twist, dt):
        """Take over the true Pose and Twist after ``dt`` [s]: what ``roll`` comes to without slip and noise."""
        self.pose, self.twist = pose, twist
        self.distance += math.hypot(twist.x, twist.y) * dt
