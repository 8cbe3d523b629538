"""The Robotont's base: three omni wheels, their limits, and the odometry that they measure.

Frame base_link: x forward, y to the left. Wheels are in the order of WHEELS; a wheel's speed is positive when it turns
the robot counter-clockwise, which is the direction of its joint in the URDF (axis towards the middle).
"""
import math
import random as random_numbers
from typing import NamedTuple, Optional, Sequence, Tuple

from kinematic_core.worlds.planar import ORIGIN, STILL, Pose2D, Twist2D, advance

WHEELS = ('back', 'right', 'left')
WHEEL_ANGLES = (math.pi, -math.pi / 3.0, math.pi / 3.0)  # [rad] direction of each wheel from the middle
WHEEL_RADIUS = 0.035  # [m]
WHEEL_DISTANCE = 0.146  # [m] of each wheel from the middle
_TANGENTS = tuple((-math.sin(angle), math.cos(angle)) for angle in WHEEL_ANGLES)  # direction in which a wheel pushes
(_BACK_X, _BACK_Y), (_RIGHT_X, _RIGHT_Y), (_LEFT_X, _LEFT_Y) = _TANGENTS


def wheel_speeds(twist: Twist2D) -> Tuple[float, float, float]:
    """Return the speeds of the three wheels [rad/s] for a body twist; given a displacement, their angles [rad]."""
    x, y = twist.linear_x, twist.linear_y
    turn = twist.angular_z * WHEEL_DISTANCE
    return ((_BACK_X * x + _BACK_Y * y + turn) / WHEEL_RADIUS,
            (_RIGHT_X * x + _RIGHT_Y * y + turn) / WHEEL_RADIUS,
            (_LEFT_X * x + _LEFT_Y * y + turn) / WHEEL_RADIUS)


def body_twist(speeds: Sequence[float]) -> Twist2D:
    """Return the body twist that three wheel speeds [rad/s] make: the inverse of ``wheel_speeds``."""
    scale = 2.0 / 3.0 * WHEEL_RADIUS
    return Twist2D(scale * sum(speed * tangent[0] for speed, tangent in zip(speeds, _TANGENTS)),
                   scale * sum(speed * tangent[1] for speed, tangent in zip(speeds, _TANGENTS)),
                   sum(speeds) * WHEEL_RADIUS / (3.0 * WHEEL_DISTANCE))


class Limits(NamedTuple):
    """The limits of base and wheels; infinite by default, as in Gazebo."""

    speed: float = math.inf  # [m/s] of the middle, in any direction
    turn_speed: float = math.inf  # [rad/s]
    wheel_speed: float = math.inf  # [rad/s]
    acceleration: float = math.inf  # [m/s^2]
    turn_acceleration: float = math.inf  # [rad/s^2]
    wheel_acceleration: float = math.inf  # [rad/s^2]

    def limited(self, twist: Twist2D) -> Twist2D:
        """Return the twist, scaled down as a whole to the limits, so that the robot stays on the commanded path."""
        return _scaled(twist, self.speed, self.turn_speed, self.wheel_speed)

    def approached(self, twist: Twist2D, target: Twist2D, dt: float) -> Twist2D:
        """Return the twist after ``dt`` [s] of changing from ``twist`` straight towards ``target``."""
        change = Twist2D(target.linear_x - twist.linear_x, target.linear_y - twist.linear_y,
                         target.angular_z - twist.angular_z)
        allowed = _scaled(change, self.acceleration * dt, self.turn_acceleration * dt, self.wheel_acceleration * dt)
        if allowed is change:
            return target
        return Twist2D(twist.linear_x + allowed.linear_x, twist.linear_y + allowed.linear_y,
                       twist.angular_z + allowed.angular_z)


UNLIMITED = Limits()


def _scaled(twist: Twist2D, linear: float, angular: float, wheel: float) -> Twist2D:
    """Return the twist itself if all of it is allowed, else the longest allowed part of it."""
    scale = 1.0
    speed, fastest_wheel = math.hypot(twist.linear_x, twist.linear_y), max(map(abs, wheel_speeds(twist)))
    for value, limit in ((speed, linear), (abs(twist.angular_z), angular), (fastest_wheel, wheel)):
        if value > limit:
            scale = min(scale, limit / value)
    if scale == 1.0:
        return twist
    return Twist2D(twist.linear_x * scale, twist.linear_y * scale, twist.angular_z * scale)


class Odometry:
    """Pose and velocity as the robot computes them from its wheels.

    ``pose`` and ``twist`` are the estimates, ``distance`` [m] is the length of the path since the start. ``slip`` is
    the share of the wheels' turning that does not move the robot: with 0.1 the odometry shows 1 / 0.9 times the real
    distance. ``noise`` [m] is the standard deviation of each wheel's path after one metre; it grows with the square
    root of the path, and so does not depend on the length of the steps.
    """

    pose: Pose2D
    twist: Twist2D
    distance: float

    def __init__(self, pose: Pose2D = ORIGIN, slip: float = 0.0, noise: float = 0.0,
                 random: Optional[random_numbers.Random] = None) -> None:
        """Start at ``pose``; ``random`` is required with noise."""
        self.slip, self.noise = slip, noise
        self._random = random
        self.exact = not slip and not noise
        self.start(pose)

    def start(self, pose: Pose2D) -> None:
        """Start again at a pose, standing still."""
        self.pose, self.twist, self.distance = pose, STILL, 0.0

    def roll(self, twist: Twist2D, dt: float) -> None:
        """Integrate ``dt`` [s] during which the robot really moved with ``twist``."""
        speeds = [speed / (1.0 - self.slip) for speed in wheel_speeds(twist)]
        if self.noise:
            assert self._random is not None, 'noise needs a random.Random'
            gauss = self._random.gauss
            lengths = [abs(speed) * WHEEL_RADIUS * dt for speed in speeds]  # [m] of each wheel's path
            speeds = [speed + gauss(0.0, 1.0) * self.noise * math.sqrt(length) / (WHEEL_RADIUS * dt)
                      for speed, length in zip(speeds, lengths)]
        self.twist = body_twist(speeds)
        self.pose = advance(self.pose, self.twist, dt)
        self.distance += math.hypot(self.twist.linear_x, self.twist.linear_y) * dt

    def follow(self, pose: Pose2D, twist: Twist2D, dt: float) -> None:
        """Take over the true pose and twist after ``dt`` [s]: what ``roll`` computes without slip and noise."""
        self.pose, self.twist = pose, twist
        self.distance += math.hypot(twist.linear_x, twist.linear_y) * dt
