"""How a turtle follows a frame: its velocity, and how to notice that the frame is no longer sent."""
import math
from typing import Hashable, Optional

from kinematic_core.worlds.planar import Twist2D

SPEED_GAIN = 0.5  # [1/s] speed per distance, that of the tutorials
TURN_GAIN = 4.0  # [1/s] turn speed per angle, that of the tutorials
LONGEST_SILENCE = 1.0  # [s] without a new transform before the follower stops; turtlesim sends 62 per second
CARROT_ORBIT = 10.0  # [m] radius of the carrot that moves
CARROT_TURN_SPEED = math.pi  # [rad/s]


def velocity_towards(x: float, y: float) -> Twist2D:
    """Return the velocity towards a point ``x`` [m] ahead of the turtle and ``y`` [m] to its left."""
    return Twist2D(linear_x=SPEED_GAIN * math.hypot(x, y), angular_z=TURN_GAIN * math.atan2(y, x))


def moving_carrot(time: float) -> 'tuple[float, float]':
    """Return the position (x, y) [m] of the carrot that goes round its turtle, at a time [s]."""
    angle = math.fmod(CARROT_TURN_SPEED * time, 2.0 * math.pi)
    return CARROT_ORBIT * math.sin(angle), CARROT_ORBIT * math.cos(angle)


class Freshness:
    """Tells a transform that is sent again and again from one that tf only remembers.

    It counts how long the stamp has not changed, by the follower's own clock: the clocks of two machines may differ.
    """

    def __init__(self) -> None:
        self._stamp: Optional[Hashable] = None
        self._since = 0.0

    def is_fresh(self, stamp: Hashable, now: float) -> bool:
        """Return whether a transform with this stamp is in use; ``now`` [s]. A false stamp is that of a static one."""
        if stamp != self._stamp or now < self._since:  # time jumps back when a simulation starts again
            self._stamp, self._since = stamp, now
        return not stamp or now - self._since <= LONGEST_SILENCE
