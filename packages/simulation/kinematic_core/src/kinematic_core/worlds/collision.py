"""A disc among the boxes and cylinders of a floor plan: it stops at them, slides along them, never passes through."""
import math
from typing import NamedTuple, Optional, Sequence, Tuple, Union

from kinematic_core.worlds.floor_plan import Box, Cylinder, FloorPlan

STEP_HEIGHT = 0.06  # [m] lower obstacles are rolled over: the thresholds of the mazes' doors
NEAR = 0.5  # [m] obstacles within this distance of the disc are checked, until it has moved by half of it
ROUNDING = 1e-9  # [m] by which the disc may overlap an obstacle
PUSHES = 12  # attempts to leave all obstacles that the disc overlaps


class Move(NamedTuple):
    """The end (x, y) [m] of a straight move, and whether the disc touched an obstacle."""

    x: float
    y: float
    touched: bool


class Obstacles:
    """The obstacles that a FloorPlan holds for an upright cylinder of ``radius`` and ``height`` [m].

    The cylinder rolls over solids lower than STEP_HEIGHT and drives under those that hang higher than its top.
    """

    def __init__(self, plan: FloorPlan, radius: float, height: float) -> None:
        self.radius = radius
        self._all = [_obstacle(solid) for solid in plan.bodies()
                     if solid.bottom + solid.height > STEP_HEIGHT and solid.bottom < height]
        self._near: Sequence[_Obstacle] = self._all
        self._near_x, self._near_y = math.inf, math.inf
        self._others: Sequence[_Obstacle] = ()

    def set_others(self, others: Sequence[Cylinder]) -> None:
        """Set what moves by itself, such as other robots: obstacles in addition to those of the plan."""
        self._others = [_RoundObstacle(other) for other in others]

    def clearance(self, x: float, y: float) -> float:
        """Return a distance [m] by which the disc at (x, y) can move in any direction without touching anything.

        It is exact up to NEAR / 2; negative when the disc overlaps an obstacle.
        """
        closest = NEAR / 2.0
        for obstacle in self._around(x, y):
            closest = min(closest, obstacle.distance(x, y) - self.radius)
        return closest

    def at(self, x: float, y: float) -> Optional[str]:
        """Return the name of the obstacle that the disc at (x, y) overlaps most, or None."""
        distance, name = min(((obstacle.distance(x, y), obstacle.name) for obstacle in self._around(x, y)),
                             default=(math.inf, None))
        return name if distance < self.radius - ROUNDING else None

    def nearest_free(self, x: float, y: float) -> Optional[Tuple[float, float]]:
        """Return (x, y), or a position beside the obstacles that the disc overlaps there; None if none is found."""
        return self._pushed_out(x, y)[0]

    def move(self, x: float, y: float, dx: float, dy: float) -> Move:
        """Move straight by (dx, dy) [m] from (x, y), where the disc is free.

        At an obstacle the component that leads into it is lost, and the rest slides along it.
        """
        touched = False
        left = math.hypot(dx, dy)
        if not left:
            return Move(x, y, touched)
        dx, dy = dx / left, dy / left
        # shorter than the radius: the disc's middle cannot get to the other side of even the thinnest obstacle
        short = self.radius / 4.0
        while left > 0.0:
            length = min(left, max(self.clearance(x, y), short))
            left -= length
            free, pushed = self._pushed_out(x + dx * length, y + dy * length)
            if pushed:
                touched = True
                if free is None or math.hypot(free[0] - x, free[1] - y) < ROUNDING:
                    break
            assert free is not None  # it is None only if the disc was pushed
            x, y = free
        return Move(x, y, touched)

    def _around(self, x: float, y: float) -> 'Sequence[_Obstacle]':
        if not (abs(x - self._near_x) < NEAR / 4.0 and abs(y - self._near_y) < NEAR / 4.0):
            reach = self.radius + NEAR
            self._near = [obstacle for obstacle in self._all if obstacle.distance(x, y) < reach]
            self._near_x, self._near_y = x, y
        return [*self._near, *self._others] if self._others else self._near

    def _pushed_out(self, x: float, y: float) -> Tuple[Optional[Tuple[float, float]], bool]:
        """Return the free position nearest to (x, y), None if there is none, and whether it differs from (x, y)."""
        around = self._around(x, y)
        radius = self.radius
        pushed = False
        for _ in range(PUSHES):
            deepest, obstacle = radius - ROUNDING, None
            for candidate in around:
                distance = candidate.distance(x, y)
                if distance < deepest:
                    deepest, obstacle = distance, candidate
            if obstacle is None:
                return (x, y), pushed
            pushed = True
            x, y = obstacle.push_out(x, y, radius)
        return None, True


class _RoundObstacle:
    __slots__ = ('name', 'x', 'y', 'radius')

    def __init__(self, cylinder: Cylinder) -> None:
        self.name, self.x, self.y, self.radius = cylinder.name, cylinder.x, cylinder.y, cylinder.radius

    def distance(self, x: float, y: float) -> float:
        """Return the distance of a point from the surface [m], negative inside."""
        return math.hypot(x - self.x, y - self.y) - self.radius

    def push_out(self, x: float, y: float, distance: float) -> Tuple[float, float]:
        """Return the nearest point to (x, y) at ``distance`` from the surface."""
        dx, dy = x - self.x, y - self.y
        length = math.hypot(dx, dy)
        if not length:
            dx, length = 1.0, 1.0
        scale = (self.radius + distance) / length
        return self.x + dx * scale, self.y + dy * scale


class _BoxObstacle:
    __slots__ = ('name', 'x', 'y', 'cos', 'sin', 'half_length', 'half_width')

    def __init__(self, box: Box) -> None:
        self.name, self.x, self.y = box.name, box.x, box.y
        self.cos, self.sin = math.cos(box.yaw), math.sin(box.yaw)
        self.half_length, self.half_width = box.length / 2.0, box.width / 2.0

    def distance(self, x: float, y: float) -> float:
        """Return the distance of a point from the outline [m], negative inside."""
        dx, dy = x - self.x, y - self.y
        beyond_x = abs(self.cos * dx + self.sin * dy) - self.half_length
        beyond_y = abs(self.cos * dy - self.sin * dx) - self.half_width
        if beyond_x <= 0.0:
            return beyond_x if beyond_x > beyond_y else beyond_y
        if beyond_y <= 0.0:
            return beyond_x
        return math.sqrt(beyond_x * beyond_x + beyond_y * beyond_y)

    def push_out(self, x: float, y: float, distance: float) -> Tuple[float, float]:
        """Return the nearest point to (x, y) at ``distance`` from the outline."""
        dx, dy = x - self.x, y - self.y
        along, across = self.cos * dx + self.sin * dy, self.cos * dy - self.sin * dx
        beyond_x, beyond_y = abs(along) - self.half_length, abs(across) - self.half_width
        if beyond_x > 0.0 and beyond_y > 0.0:  # off a corner: away from it
            scale = distance / math.hypot(beyond_x, beyond_y)
            along = math.copysign(self.half_length + beyond_x * scale, along)
            across = math.copysign(self.half_width + beyond_y * scale, across)
        elif beyond_x > beyond_y:
            along = math.copysign(self.half_length + distance, along)
        else:
            across = math.copysign(self.half_width + distance, across)
        return self.x + self.cos * along - self.sin * across, self.y + self.sin * along + self.cos * across


_Obstacle = Union[_RoundObstacle, _BoxObstacle]


def _obstacle(solid: Union[Box, Cylinder]) -> _Obstacle:
    return _BoxObstacle(solid) if isinstance(solid, Box) else _RoundObstacle(solid)
