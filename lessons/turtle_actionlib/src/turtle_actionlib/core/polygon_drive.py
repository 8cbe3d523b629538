"""Drive a turtle round a regular polygon, one edge and one turn after the other, as its poses come."""
import math
from typing import Optional

from kinematic_core.worlds.angles import wrap_angle
from kinematic_core.worlds.planar import STILL, Pose2D, Twist2D

GAIN = 6.0  # [1/s] of distance and angle, that of the original
TOLERANCE = 1e-5  # [m] and [rad], that of the original
LEAST_EDGES, MOST_EDGES = 3, 100
LEAST_RADIUS, LARGEST_RADIUS = 0.1, 11.0  # [m] turtlesim's arena is 11.1 m wide


class Polygon:
    """A regular polygon."""

    def __init__(self, edges: int, radius: float) -> None:
        """``radius`` [m]: from the centre to the corners. Raise ValueError if no turtle can drive it."""
        if not LEAST_EDGES <= edges <= MOST_EDGES:
            raise ValueError(f'edges is {edges}; it must be {LEAST_EDGES} to {MOST_EDGES}')
        if not LEAST_RADIUS <= radius <= LARGEST_RADIUS:
            raise ValueError(f'radius is {radius:g}; it must be {LEAST_RADIUS:g} to {LARGEST_RADIUS:g} m')
        self.edges = edges
        self.interior_angle = math.pi * (edges - 2) / edges  # [rad]
        self.apothem = radius * math.cos(math.pi / edges)  # [m] from the centre to the middle of an edge
        self.side = 2.0 * radius * math.sin(math.pi / edges)  # [m]


class PolygonDrive:
    """Computes, from each pose, the velocity that draws the polygon; it turns left at each corner."""

    def __init__(self, polygon: Polygon) -> None:
        self._polygon = polygon
        self._edges_left = polygon.edges
        self._corner: Optional[Pose2D] = None  # where the present edge starts

    def step(self, pose: Pose2D) -> Optional[Twist2D]:
        """Return the velocity for this pose; None once the turtle is back and turned as at the start."""
        if not self._edges_left:
            return None
        if self._corner is None:
            self._corner = pose
        way = self._polygon.side - math.hypot(pose.x - self._corner.x, pose.y - self._corner.y)
        turn = wrap_angle(math.pi - self._polygon.interior_angle - (pose.yaw - self._corner.yaw))
        if way > TOLERANCE:
            return Twist2D(linear_x=GAIN * way)
        if abs(turn) > TOLERANCE:
            return Twist2D(angular_z=GAIN * turn)
        self._edges_left -= 1
        self._corner = None
        return STILL
