"""A disc among the boxes and cylinders of a floor plan: it stops at them, slides along them, never gets through."""
import math

from kinematic_core.floor_plan import Box

STEP_HEIGHT = 0.06  # [m] what is not higher is rolled over: the thresholds of the mazes' doors
NEAR = 0.5  # [m] obstacles within this distance of the disc are looked at, until it has moved on by half of it
ROUNDING = 1e-9  # [m] by which the disc may reach into an obstacle
PUSHES = 12  # attempts to get out of several obstacles at once


class Obstacles:
    """What of a FloorPlan stands in the way of an upright cylinder of ``radius`` and ``height`` [m].

    Lower things than STEP_HEIGHT are rolled over, things that hang higher than the robot are driven under.
    """

    def __init__(self, plan, radius, height):
        self.radius = radius
        self._all = [_obstacle(solid) for solid in plan.solids()
                     if solid.bottom + solid.height > STEP_HEIGHT and solid.bottom < height]
        self._near, self._near_x, self._near_y = self._all, math.inf, math.inf

    def clearance(self, x, y):
        """Return a distance [m] that the disc at (x, y) can be moved in any direction and touch nothing.

        It is exact up to NEAR / 2; negative when the disc reaches into an obstacle.
        """
        closest = NEAR / 2.0
        for obstacle in self._around(x, y):
            closest = min(closest, obstacle.distance(x, y) - self.radius)
        return closest

    def at(self, x, y):
        """Return the name of the obstacle that the disc at (x, y) reaches into the deepest, or None."""
        distance, name = min(((obstacle.distance(x, y), obstacle.name) for obstacle in self._around(x, y)),
                             default=(math.inf, None))
        return name if distance < self.radius - ROUNDING else None

    def move(self, x, y, dx, dy):
        """Return (x, y, touched) after a straight way (dx, dy) [m] from (x, y), where the disc is free.

        At an obstacle the part of the way that leads into it is lost, and the rest slides along it.
        """
        touched = False
        left = math.hypot(dx, dy)
        if not left:
            return x, y, touched
        dx, dy = dx / left, dy / left
        # shorter than the radius: the disc's middle cannot get to the other side of even the thinnest obstacle
        short = self.radius / 4.0
        while left > 0.0:
            way = min(left, max(self.clearance(x, y), short))
            left -= way
            new_x, new_y, pushed = self._pushed_out(x + dx * way, y + dy * way)
            if pushed:
                touched = True
                if new_x is None or math.hypot(new_x - x, new_y - y) < ROUNDING:
                    break
            x, y = new_x, new_y
        return x, y, touched

    def _around(self, x, y):
        if not (abs(x - self._near_x) < NEAR / 4.0 and abs(y - self._near_y) < NEAR / 4.0):
            reach = self.radius + NEAR
            self._near = [obstacle for obstacle in self._all if obstacle.distance(x, y) < reach]
            self._near_x, self._near_y = x, y
        return self._near

    def _pushed_out(self, x, y):
        """Return the nearest free place beside (x, y), None where there is none, and whether it is another one."""
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
                return x, y, pushed
            pushed = True
            x, y = obstacle.push_out(x, y, radius)
        return None, None, True


class _RoundObstacle:
    __slots__ = ('name', 'x', 'y', 'radius')

    def __init__(self, name, x, y, radius):
        self.name, self.x, self.y, self.radius = name, x, y, radius

    def distance(self, x, y):
        """Return the distance of a point from the surface [m], negative inside."""
        return math.hypot(x - self.x, y - self.y) - self.radius

    def push_out(self, x, y, distance):
        """Return the nearest point to (x, y) at ``distance`` from the surface."""
        dx, dy = x - self.x, y - self.y
        length = math.hypot(dx, dy)
        if not length:
            dx, length = 1.0, 1.0
        scale = (self.radius + distance) / length
        return self.x + dx * scale, self.y + dy * scale


class _BoxObstacle:
    __slots__ = ('name', 'x', 'y', 'cos', 'sin', 'half_length', 'half_width')

    def __init__(self, name, x, y, yaw, length, width):
        self.name, self.x, self.y = name, x, y
        self.cos, self.sin = math.cos(yaw), math.sin(yaw)
        self.half_length, self.half_width = length / 2.0, width / 2.0

    def distance(self, x, y):
        """Return the distance of a point from the outline [m], negative inside."""
        dx, dy = x - self.x, y - self.y
        beyond_x = abs(self.cos * dx + self.sin * dy) - self.half_length
        beyond_y = abs(self.cos * dy - self.sin * dx) - self.half_width
        if beyond_x <= 0.0:
            return beyond_x if beyond_x > beyond_y else beyond_y
        if beyond_y <= 0.0:
            return beyond_x
        return math.sqrt(beyond_x * beyond_x + beyond_y * beyond_y)

    def push_out(self, x, y, distance):
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


def _obstacle(solid):
    if isinstance(solid, Box):
        return _BoxObstacle(solid.name, solid.x, solid.y, solid.yaw, solid.length, solid.width)
    return _RoundObstacle(solid.name, solid.x, solid.y, solid.radius)
