"""Shapes that a turtle or a robot can draw: the positions of their corners, and whether they fit into the arena.

Positions are in metres, 0 .. ARENA_SIZE, origin in the lower left corner, y up; headings in rad, counter-clockwise
from +x. A shape with a size starts and ends at the vehicle's position, begins in the direction of its heading, and lies
to its left. ``size`` [m] is the length of a side, or the diameter of a circle.

To add a shape made of straight lines, write a function like ``polygon`` and enter it in POLYGONS; nodes, services and
texts use that table. A curve also needs a drive, which turtle_robotont.driving.drawing chooses.
"""
import math
from functools import partial
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Protocol, Sequence

ARENA_SIZE = 11.088889122009277  # [m] side of turtlesim's window: the float32 of 499 pixels of 1 / 45 m
DEFAULT_SIZE = 2.0  # [m]
DEFAULT_CORNERS = [[4.0, 4.0], [7.0, 4.0], [7.0, 7.0], [4.0, 7.0]]  # [m]
ROBOT_SIZE = 0.5  # [m] fits where a Robotont starts in its maze
ROBOT_CORNERS = [[0.0, 0.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]]  # [m] in odom
CIRCLE_ENDS = ('right end', 'upper end', 'left end', 'lower end')
SMALLEST = 0.1  # [m] the smallest size of a shape
EDGE = 1e-6  # [m] by which rounding may put a corner outside


class InvalidInput(ValueError):
    """A value was refused; the text names the value and the allowed range."""


class HasPosition(Protocol):
    """Anything with x and y [m]."""

    @property
    def x(self) -> float:
        """Return x [m]."""

    @property
    def y(self) -> float:
        """Return y [m]."""


class HasPose(HasPosition, Protocol):
    """Anything with x, y [m] and theta [rad], such as a VehicleState or a turtlesim/Pose."""

    @property
    def theta(self) -> float:
        """Return the heading [rad]."""


class Point(NamedTuple):
    """A position [m]."""

    x: float
    y: float


def wrap_angle(theta: float) -> float:
    """Wrap an angle [rad] to [-pi, pi]."""
    return math.remainder(theta, 2.0 * math.pi)


def distance(a: HasPosition, b: HasPosition) -> float:
    """Return the distance [m] between two things that have x and y."""
    return math.hypot(b.x - a.x, b.y - a.y)


def polygon(sides: int, size: float, start: HasPose) -> List[Point]:
    """Return the corners of a regular polygon in the order of driving; the last one is the position ``start`` again."""
    corners, x, y = [], start.x, start.y
    for side in range(sides):
        heading = start.theta + side * 2.0 * math.pi / sides
        x, y = x + size * math.cos(heading), y + size * math.sin(heading)
        corners.append(Point(x, y))
    corners[-1] = Point(start.x, start.y)
    return corners


def circle_centre(size: float, start: HasPose) -> Point:
    """Return the centre of the circle of diameter ``size`` to the left of ``start``."""
    radius = size / 2.0
    return Point(start.x - radius * math.sin(start.theta), start.y + radius * math.cos(start.theta))


POLYGONS: Dict[str, Callable[[float, HasPose], List[Point]]] = {  # name: function of size [m] and start: the corners
    'square': partial(polygon, 4),
    'triangle': partial(polygon, 3),
}
SHAPES = (*POLYGONS, 'circle', 'corners')


def outline(shape: str, size: float, start: HasPose) -> List[Point]:
    """Return the points that decide whether a polygon or circle fits: its corners, or the four CIRCLE_ENDS."""
    if shape in POLYGONS:
        return POLYGONS[shape](size, start)
    centre, radius = circle_centre(size, start), size / 2.0
    return [Point(centre.x + dx * radius, centre.y + dy * radius) for dx, dy in ((1, 0), (0, 1), (-1, 0), (0, -1))]


def points_from(corners: Sequence[Any]) -> List[Point]:
    """Return Points from pairs [x, y]; raise InvalidInput naming the first entry that is not a pair."""
    for number, corner in enumerate(corners, 1):
        if not isinstance(corner, (list, tuple)) or len(corner) != 2:
            raise InvalidInput(f'corner {number} is {corner}; it must be a pair [x, y] in metres, '
                               f'e.g. {DEFAULT_CORNERS}')
    if len(corners) < 2:
        raise InvalidInput(f'{len(corners)} corners are given; at least 2 are needed, e.g. {DEFAULT_CORNERS}')
    return [Point(float(x), float(y)) for x, y in corners]


def require_size(size: float) -> float:
    """Return size; raise InvalidInput unless it is finite and at least SMALLEST."""
    if not math.isfinite(size) or size < SMALLEST:
        raise InvalidInput(f'the size is {size:g} m; it must be a number from {SMALLEST:g} to {ARENA_SIZE:.2f} m')
    return size


def require_fit(points: Sequence[HasPosition], names: Optional[Sequence[str]] = None) -> None:
    """Raise InvalidInput naming every point outside the arena: by ``names``, or as corner 1, corner 2, ..."""
    names = names or [f'corner {number}' for number in range(1, len(points) + 1)]
    outside = [f'{name} ({point.x:.2f}, {point.y:.2f})' for name, point in zip(names, points)
               if not (-EDGE <= point.x <= ARENA_SIZE + EDGE and -EDGE <= point.y <= ARENA_SIZE + EDGE)]
    if outside:
        raise InvalidInput(f'{", ".join(outside)} outside the arena; x and y must be 0 to {ARENA_SIZE:.2f} m')


def require_shape_fits(shape: str, size: float, start: HasPose) -> None:
    """Raise InvalidInput, with the largest size that fits, unless the shape drawn from ``start`` fits."""
    require_size(size)
    try:
        require_fit(outline(shape, size, start), CIRCLE_ENDS if shape == 'circle' else None)
    except InvalidInput as error:
        raise InvalidInput(f'a {shape} of size {size:g} m from ({start.x:.2f}, {start.y:.2f}), heading '
                           f'{start.theta:.2f} rad, would leave the arena: {error}; {_advice(shape, start)}') from None


def largest_size(shape: str, start: HasPose) -> float:
    """Return the largest size [m] with which the shape drawn from ``start`` fits into the arena."""
    sizes = [math.inf]
    for point in outline(shape, 1.0, start):  # the distance of every point from the start is proportional to the size
        for origin, end in ((start.x, point.x), (start.y, point.y)):
            if end - origin > EDGE:
                sizes.append((ARENA_SIZE - origin) / (end - origin))
            elif origin - end > EDGE:
                sizes.append(origin / (origin - end))
    return max(0.0, min(sizes))


def _advice(shape: str, start: HasPose) -> str:
    largest = math.floor(100.0 * largest_size(shape, start)) / 100.0
    if largest < SMALLEST:
        return 'first drive the turtle away from the wall, or turn it'
    return f'from here the largest possible size is {largest:.2f} m'
