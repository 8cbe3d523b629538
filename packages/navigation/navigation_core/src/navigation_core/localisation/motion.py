"""How particles move with the odometry: the sampled motion models of Thrun, Burgard and Fox, Probabilistic Robotics.

The model ``diff`` splits a step into rotation, translation and rotation, ``omni`` into translation and rotation. They
use the variances of the book as standard deviations, like old versions of amcl; those with ``-corrected`` take the
square root.
"""
import math
from typing import Sequence

import numpy as np

from navigation_core.poses import Array, Pose, wrap

MODELS = 'diff', 'omni', 'diff-corrected', 'omni-corrected'
SHORT = 0.01  # [m] shorter translations have no direction


def moved(particles: Array, step: Pose, alphas: Sequence[float], model: str, random: np.random.Generator) -> Array:
    """Return the particles (n, 3) after a step of the odometry, each with an error of its own.

    ``step`` is the new pose in the frame of the old one; ``alphas`` are amcl's odom_alpha1 to 5.
    """
    way, bearing = math.hypot(step.x, step.y), math.atan2(step.y, step.x)

    def error(variance: float) -> Array:
        sigma = math.sqrt(variance) if model.endswith('corrected') else variance
        return random.normal(0.0, 1.0, len(particles)) * sigma
    a1, a2, a3, a4, a5 = alphas
    square, turn = way * way, step.yaw * step.yaw
    if model.startswith('omni'):
        ways, asides = way + error(a3 * square + a1 * turn), error(a1 * turn + a5 * square)
        headings = particles[:, 2] + bearing
        yaws = particles[:, 2] + step.yaw + error(a4 * turn + a2 * square)
    else:
        first = bearing if way >= SHORT else 0.0
        second = float(wrap(step.yaw - first))
        first_turn, second_turn = (min(abs(each), math.pi - abs(each)) ** 2 for each in (first, second))
        headings = particles[:, 2] + first + error(a1 * first_turn + a2 * square)
        ways = way + error(a3 * square + a4 * (first_turn + second_turn))
        asides = np.zeros(len(particles))
        yaws = headings + second + error(a1 * second_turn + a2 * square)
    cos, sin = np.cos(headings), np.sin(headings)
    return np.stack([particles[:, 0] + cos * ways - sin * asides, particles[:, 1] + sin * ways + cos * asides,
                     wrap(yaws)], axis=1)
