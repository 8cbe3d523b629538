"""Shapes that a turtle or a robot can draw: where their corners lie and whether they fit into the turtles' arena.

Positions are in metres, 0 .. ARENA_SIZE, origin in the lower left corner, y up; headings in rad, counter-clockwise
from +x. A square, triangle or circle begins where the turtle stands, sets off in the direction that it faces, lies
to its left and ends where it began. ``size`` is the length of a side, of a circle the diameter [m].
"""
import math
from typing import NamedTuple

from kinematic_core.checks import InvalidInput
from kinematic_core.turtle_world import ARENA_SIZE

SIDES = {'square': 4, 'triangle': 3}
SHAPES = ('square', 'triangle', 'circle', 'corners')
DEFAULT_SIZE = 2.0  # [m]
DEFAULT_CORNERS = [[4.0, 4.0], [7.0, 4.0], [7.0, 7.0], [4.0, 7.0]]  # [m]
ROBOT_SIZE = 0.5  # [m] has room where a Robotont starts in its maze
ROBOT_CORNERS = [[0.0, 0.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]]  # [m] in odom
CIRCLE_ENDS = ('right end', 'upper end', 'left end', 'lower end')
SMALLEST = 0.1  # [m] size that can be told from a dot
STEEP = 1e-6  # a heading whose cosine is smaller leads to no x
EDGE = 1e-6  # [m] a corner may lie outside by rounding


class Point(NamedTuple):
    """A position [m]."""

    x: float
    y: float


def distance(a, b):
    """Return the distance [m] of two things that have x and y."""
    return math.hypot(b.x - a.x, b.y - a.y)


def polygon(sides, size, start):
    """Return the corners of a regular polygon in the order of driving; the last one is the pose ``start`` again."""
    corners, x, y = [], start.x, start.y
    for side in range(sides):
        heading = start.theta + side * 2.0 * math.pi / sides
        x, y = x + size * math.cos(heading), y + size * math.sin(heading)
        corners.append(Point(x, y))
    corners[-1] = Point(start.x, start.y)
    return corners


def circle_centre(size, start):
    """Return the centre of the circle of diameter ``size`` to the left of the pose ``start``."""
    radius = size / 2.0
    return Point(start.x - radius * math.sin(start.theta), start.y + radius * math.cos(start.theta))


def outline(shape, size, start):
    """Return the points that decide whether a square, triangle or circle fits: corners, or CIRCLE_ENDS."""
    if shape in SIDES:
        return polygon(SIDES[shape], size, start)
    centre, radius = circle_centre(size, start), size / 2.0
    return [Point(centre.x + dx * radius, centre.y + dy * radius) for dx, dy in ((1, 0), (0, 1), (-1, 0), (0, -1))]


def point_at_x(pose, x):
    """Return where to go so that the turtle stands at ``x`` [m].

    That is straight ahead where the heading leads there inside the arena, else at the turtle's own height.
    """
    ahead = math.cos(pose.theta)
    if abs(ahead) > STEEP and (x - pose.x) * ahead >= 0.0:
        y = pose.y + (x - pose.x) * math.tan(pose.theta)
        if 0.0 <= y <= ARENA_SIZE:
            return Point(x, y)
    return Point(x, pose.y)


def points_from(corners):
    """Return a list of Points from pairs [x, y]; raise InvalidInput naming the first entry that is not a pair."""
    for number, corner in enumerate(corners, 1):
        if not isinstance(corner, (list, tuple)) or len(corner) != 2:
            raise InvalidInput(f'corner {number} is {corner}; it must be a pair [x, y] in metres, '
                               f'e.g. {DEFAULT_CORNERS}')
    if len(corners) < 2:
        raise InvalidInput(f'there are {len(corners)} corners; at least 2 are needed, e.g. {DEFAULT_CORNERS}')
    return [Point(float(x), float(y)) for x, y in corners]


def require_size(size):
    """Return size; raise InvalidInput unless it is finite and at least SMALLEST."""
    if not math.isfinite(size) or size < SMALLEST:
        raise InvalidInput(f'the size is {size:g} m; it must be a number from {SMALLEST:g} to {ARENA_SIZE:.2f} m')
    return size


def require_fit(points, names=None):
    """Raise InvalidInput naming every point outside the arena, with its name or as the corner of its number."""
    names = names or [f'corner {number}' for number in range(1, len(points) + 1)]
    outside = [f'{name} ({point.x:.2f}, {point.y:.2f})' for name, point in zip(names, points)
               if not (-EDGE <= point.x <= ARENA_SIZE + EDGE and -EDGE <= point.y <= ARENA_SIZE + EDGE)]
    if outside:
        raise InvalidInput(f'{", ".join(outside)} outside the arena; allowed is 0 to {ARENA_SIZE:.2f} m in x and y')


def require_shape_fits(shape, size, start):
    """Raise InvalidInput, with the largest size that fits, unless the shape drawn from ``start`` fits."""
    require_size(size)
    try:
        require_fit(outline(shape, size, start), CIRCLE_ENDS if shape == 'circle' else None)
    except InvalidInput as error:
        raise InvalidInput(f'a {shape} of size {size:g} m from ({start.x:.2f}, {start.y:.2f}), heading '
                           f'{start.theta:.2f} rad, would leave the arena: {error}; {_advice(shape, start)}') from None


def largest_size(shape, start):
    """Return the largest size [m] of which the shape drawn from the pose ``start`` fits into the arena."""
    sizes = [math.inf]
    for point in outline(shape, 1.0, start):  # every point moves away from the start in proportion to the size
        for begin, end in ((start.x, point.x), (start.y, point.y)):
            if end - begin > EDGE:
                sizes.append((ARENA_SIZE - begin) / (end - begin))
            elif begin - end > EDGE:
                sizes.append(begin / (begin - end))
    return max(0.0, min(sizes))


def _advice(shape, start):
    largest = math.floor(100.0 * largest_size(shape, start)) / 100.0
    if largest < SMALLEST:
        return 'drive or turn the turtle away from the wall first'
    return f'from here a size of at most {largest:.2f} m fits'
