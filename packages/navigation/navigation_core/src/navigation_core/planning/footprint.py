"""The outline of a robot, seen from above."""
import math
from typing import Any, List, Tuple

import numpy as np

from navigation_core.poses import Array


class Footprint:
    """A polygon around the robot's middle, or a disc.

    ``points`` (corners, 2) [m] are its corners in the robot's frame, ``inscribed`` and ``circumscribed`` [m] the radii
    of the largest disc inside, and of the smallest disc around it that have the robot's middle as theirs.
    """

    def __init__(self, points: Array, round_as: float = 0.0) -> None:
        """``round_as``: the radius [m] of a disc that ``points`` stands for in drawings."""
        self.points = np.asarray(points, float)
        self.circumscribed = round_as or float(np.hypot(*self.points.T).max())
        self.inscribed = round_as or min(map(_distance_of_side, self.points, np.roll(self.points, -1, axis=0)))

    @classmethod
    def disc(cls, radius: float) -> 'Footprint':
        """Return the footprint of a round robot."""
        angles = np.linspace(0.0, 2.0 * math.pi, 16, endpoint=False)
        return cls(radius * np.stack([np.cos(angles), np.sin(angles)], axis=1), radius)

    @classmethod
    def polygon(cls, points: Any, padding: float = 0.0) -> 'Footprint':
        """Return the footprint with these corners, each moved outwards by ``padding`` [m] along x and y.

        Raise ValueError if it has fewer than three corners, or does not surround the robot's middle.
        """
        corners = np.asarray(points, float)
        if corners.ndim != 2 or corners.shape[1:] != (2,) or len(corners) < 3 or not np.isfinite(corners).all():
            raise ValueError('needs at least three corners [x, y]')
        corners = corners + padding * np.sign(corners)
        sides = np.roll(corners, -1, axis=0)
        turns = corners[:, 0] * sides[:, 1] - corners[:, 1] * sides[:, 0]
        if not ((turns > 0.0).all() or (turns < 0.0).all()):
            raise ValueError('does not surround the middle of the robot, (0, 0)')
        return cls(corners)

    @property
    def is_round(self) -> bool:
        """Whether it is a disc, so that its heading does not matter."""
        return self.inscribed == self.circumscribed

    def outline(self, spacing: float) -> Array:
        """Return points (n, 2) [m] on the sides, at most ``spacing`` [m] apart."""
        points: List[Tuple[float, float]] = []
        for start, end in zip(self.points, np.roll(self.points, -1, axis=0)):
            number = max(1, math.ceil(math.dist(start, end) / spacing))
            points += [tuple(start + (end - start) * part / number) for part in range(number)]
        return np.array(points)


def _distance_of_side(start: Array, end: Array) -> float:
    """Return the distance [m] of the side between two corners from the middle."""
    side = end - start
    part = float(np.clip(-(start @ side) / max(side @ side, 1e-12), 0.0, 1.0))
    return float(np.hypot(*(start + part * side)))
