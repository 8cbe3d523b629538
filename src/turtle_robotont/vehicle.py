"""What is told to a turtle or a robot, how fast it may be, and what its drives are tuned to. ROS-free."""
import math
from typing import NamedTuple

from kinematic_core.turtle_world import ARENA_SIZE


class Command(NamedTuple):
    """A velocity: linear [m/s] forward, angular [rad/s], lateral [m/s] to the left."""

    linear: float
    angular: float
    lateral: float = 0.0


STOP = Command(0.0, 0.0)


class Limits(NamedTuple):
    """The top speeds of a drive: speed [m/s] in whatever direction and turn_speed [rad/s], both above 0."""

    speed: float = 2.0
    turn_speed: float = 5.0

    def apply(self, command):
        """Return the command cut to the limits, its direction kept; the last thing that happens to it."""
        share = min(1.0, self.speed / max(self.speed, math.hypot(command.linear, command.lateral)))
        return Command(command.linear * share, max(-self.turn_speed, min(self.turn_speed, command.angular)),
                       command.lateral * share)


class Vehicle(NamedTuple):
    """What the drives of a vehicle are tuned to; the gains leave room for the delay from a command to its effect.

    name                in texts
    limits              its top speeds unless others are asked for
    acceleration        [m/s^2] at setting off and at slowing down
    approach_gain       [1/s] speed for each metre left, close to the goal; times the loop's delay at most 1/e
    turn_deceleration   [rad/s^2]
    turn_gain           [1/s] turning speed for each radian left, close to the heading
    steer_gain          [1/s] the same while driving
    standing            [m/s or rad/s] slower than this is standing
    arena               [m] side of the square that it must not leave; None: nothing is known of its surroundings
    """

    name: str
    limits: Limits
    acceleration: float
    approach_gain: float
    turn_deceleration: float
    turn_gain: float
    steer_gain: float
    standing: float
    arena: float = None


LIMITS = Limits()
TURTLE = Vehicle('turtle', LIMITS, 8.0, 7.0, 24.0, 7.0, 4.0, 1e-3, ARENA_SIZE)  # delay: three poses, 48 ms
ROBOT = Vehicle('robot', Limits(0.5, 1.0), 0.8, 2.5, 3.0, 2.5, 2.0, 0.02)  # delay: three messages of odometry, 0.1 s
