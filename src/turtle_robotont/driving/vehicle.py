"""Descriptions of vehicles for drives: state, top speeds, and the parameters of the control laws. ROS-free.

Commands are Twist2D, velocities in the vehicle's own frame.
"""
import math
from typing import NamedTuple, Optional

from turtle_robotont.driving.shapes import ARENA_SIZE


class Twist2D(NamedTuple):
    """A velocity in the plane, with the fields of a geometry_msgs/Twist that matter there.

    linear_x [m/s] forward, linear_y [m/s] to the left, angular_z [rad/s] counter-clockwise.
    """

    linear_x: float = 0.0
    linear_y: float = 0.0
    angular_z: float = 0.0


STOP = Twist2D()
TURTLE_STEP = 0.016  # [s] between two poses of turtlesim


class VehicleState(NamedTuple):
    """The pose and velocity that a drive reads; a turtlesim/Pose has the same fields and can be used instead.

    x, y [m], theta [rad] counter-clockwise from +x, linear_velocity [m/s, never negative], angular_velocity [rad/s].
    """

    x: float
    y: float
    theta: float
    linear_velocity: float = 0.0
    angular_velocity: float = 0.0


class Limits(NamedTuple):
    """The top speeds of a drive: speed [m/s] in any direction and turn_speed [rad/s], both above 0."""

    speed: float = 2.0
    turn_speed: float = 5.0

    def apply(self, command: Twist2D) -> Twist2D:
        """Return the command within the limits, its direction kept; always the last step before it is sent."""
        share = min(1.0, self.speed / max(self.speed, math.hypot(command.linear_x, command.linear_y)))
        return Twist2D(command.linear_x * share, command.linear_y * share,
                       max(-self.turn_speed, min(self.turn_speed, command.angular_z)))


class Vehicle(NamedTuple):
    """The parameters of a vehicle's drives; the gains are low enough for the delay from a command to its effect.

    name                for texts
    limits              default top speeds
    acceleration        [m/s^2] when starting and when slowing down
    approach_gain       [1/s] speed per metre left, close to the goal; times the loop's delay at most 1/e
    turn_deceleration   [rad/s^2]
    turn_gain           [1/s] angular velocity per radian left, close to the heading
    steer_gain          [1/s] the same while driving
    standing            [m/s or rad/s] slower than this counts as standing still
    arena               [m] side of the square that it must not leave; None: its surroundings are unknown
    """

    name: str
    limits: Limits
    acceleration: float
    approach_gain: float
    turn_deceleration: float
    turn_gain: float
    steer_gain: float
    standing: float
    arena: Optional[float] = None


LIMITS = Limits()
TURTLE = Vehicle('turtle', LIMITS, 8.0, 7.0, 24.0, 7.0, 4.0, 1e-3, ARENA_SIZE)  # delay: three poses, 48 ms
ROBOT = Vehicle('robot', Limits(0.5, 1.0), 0.8, 2.5, 3.0, 2.5, 2.0, 0.02)  # delay: three messages of odometry, 0.1 s
