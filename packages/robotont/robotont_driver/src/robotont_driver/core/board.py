"""The Robotont's circuit board: the state of its LED strip, and a battery. No ROS."""
from typing import List, NamedTuple, Sequence, Tuple

from kinematic_core.worlds.planar import Twist2D
from plain_support import InvalidInput

Colour = Tuple[int, int, int]  # (r, g, b), 0..255

LEDS = 60  # of the strip
OFF: Colour = (0, 0, 0)
VOLTAGE = 12.0  # [V] of a charged battery with three lithium cells, under load
IDLE_CURRENT = 0.6  # [A] of computer and board
CURRENT_OF_SPEED = 1.5  # [A s/m]; a plain model, not measured
CURRENT_OF_TURN = 0.3  # [A s/rad]


class Power(NamedTuple):
    """The battery's output: current [A], voltage [V]."""

    current: float
    voltage: float


class Board:
    """The LED strip; ``leds`` has the colour of each LED, all off at first."""

    def __init__(self) -> None:
        self.leds: List[Colour] = [OFF] * LEDS

    def light(self, first: int, colours: Sequence[Colour]) -> None:
        """Set the colours of the LEDs from number ``first`` on; raise InvalidInput for LEDs that do not exist."""
        if first + len(colours) > LEDS:
            raise InvalidInput(f'there is no LED {max(first, LEDS)}; the strip has the LEDs 0 to {LEDS - 1}')
        self.leds[first:first + len(colours)] = colours


def power(twist: Twist2D) -> Power:
    """Return the Power that the robot needs at a velocity."""
    speed = abs(twist.linear_x) + abs(twist.linear_y)
    return Power(IDLE_CURRENT + CURRENT_OF_SPEED * speed + CURRENT_OF_TURN * abs(twist.angular_z), VOLTAGE)
