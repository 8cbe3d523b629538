"""Poses in the plane, which transform points: numbers give numbers, arrays give arrays."""
import math
from typing import Any, NamedTuple, Tuple, Union

import numpy as np

Array = np.ndarray
Numbers = Union[float, Array]


class Pose(NamedTuple):
    """The pose of a frame or a robot in another frame: x, y [m], yaw [rad], counter-clockwise from +x."""

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0

    def to_outer(self, x: Numbers, y: Numbers) -> Tuple[Any, Any]:
        """Return the coordinates of points (x, y) [m] of this frame in the frame that the pose is given in."""
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return self.x + cos * x - sin * y, self.y + sin * x + cos * y

    def to_inner(self, x: Numbers, y: Numbers) -> Tuple[Any, Any]:
        """Return the coordinates in this frame of points (x, y) [m] of the frame that the pose is given in."""
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return cos * (x - self.x) + sin * (y - self.y), cos * (y - self.y) - sin * (x - self.x)

    def then(self, step: 'Pose') -> 'Pose':
        """Return the pose that ``step``, given in this frame, has in the outer frame."""
        x, y = self.to_outer(step.x, step.y)
        return Pose(float(x), float(y), float(wrap(self.yaw + step.yaw)))

    def inverse(self) -> 'Pose':
        """Return the pose of the outer frame in this frame."""
        x, y = self.to_inner(0.0, 0.0)
        return Pose(float(x), float(y), float(wrap(-self.yaw)))

    def step_to(self, other: 'Pose') -> 'Pose':
        """Return ``other``, given in the outer frame, in this frame: ``self.then(self.step_to(other)) == other``."""
        return self.inverse().then(other)


ORIGIN = Pose()


def wrap(angle: Numbers) -> Numbers:
    """Wrap angles [rad] to [-pi, pi)."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi
