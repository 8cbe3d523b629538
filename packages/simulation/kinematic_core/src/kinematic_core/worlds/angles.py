"""Angles in radians, counter-clockwise positive (REP 103)."""
import math


def wrap_angle(theta: float, pi: float = math.pi) -> float:
    """Wrap an angle [rad] to [-pi, pi), up to the rounding of its last bit.

    ``pi`` is a parameter because turtlesim wraps with a literal that is shorter than ``math.pi``.
    The order of the operations is the one whose rounding turtlesim's poses show.
    """
    two_pi = 2.0 * pi
    return theta - two_pi * math.floor((theta + pi) / two_pi)
