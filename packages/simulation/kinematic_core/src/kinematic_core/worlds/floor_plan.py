"""The objects in a robot's world: upright boxes and cylinders, and panels with AR markers. Immutable.

World frame: x forward, y to the left, z up, the floor at z = 0; metres, radians counter-clockwise (REP 103).
A plan can be shared between threads; a change makes a new plan.
"""
import bisect
import math
from typing import Any, Iterator, List, NamedTuple, Sequence, Tuple, Union

from kinematic_core.worlds.angles import wrap_angle
from plain_support import LARGEST_MARKER_ID, InvalidInput, require_sane, shown

Colour = Tuple[int, int, int]  # (r, g, b), 0..255

GREY = (178, 178, 178)
GROUND_COLOUR = (128, 128, 128)
SKY_COLOUR = (150, 190, 230)
PANEL_SIZE = 0.40  # [m] the white square
PANEL_MARKER_SIZE = 0.28  # [m] the marker's black square in its middle
PANEL_BOTTOM = 0.05  # [m]
PANEL_THICKNESS = 0.01  # [m] behind the face
LARGEST = 1000.0  # [m] of any coordinate or size of a plan
MAX_SHAPES = 1000  # of a plan, because all pairs are compared
MAX_WAYPOINTS = 1000  # of a panel
MAX_NAME_LENGTH = 200  # characters
TOUCHING = 0.01  # [m] by which shapes may overlap and still count as side by side
CIRCLE = 32  # corners of a cylinder's outline


Waypoint = Tuple[float, float, float, float]  # time [s] from the start, x, y [m], yaw [rad]


class Box(NamedTuple):
    """An upright box: centre (x, y) [m], yaw [rad]; length, width, height [m] along its own x, y, z axes."""

    name: str
    x: float
    y: float
    yaw: float
    length: float
    width: float
    height: float
    bottom: float = 0.0  # [m] z of its lower face
    colour: Colour = GREY


class Cylinder(NamedTuple):
    """An upright cylinder: axis at (x, y) [m]; radius, height [m]."""

    name: str
    x: float
    y: float
    radius: float
    height: float
    bottom: float = 0.0  # [m] z of its lower face
    colour: Colour = GREY


class Panel(NamedTuple):
    """A white square board with an ALVAR marker in its middle.

    (x, y) [m] is the middle of the face, whose normal is the panel's own -x axis: at yaw 0 it faces a viewer who looks
    along +x. The board is PANEL_THICKNESS deep, behind the face; its back and its edges are white.
    """

    name: str
    marker_id: int
    x: float
    y: float
    yaw: float  # [rad]
    size: float = PANEL_SIZE  # [m] width and height of the board
    marker_size: float = PANEL_MARKER_SIZE  # [m] width of the marker's black square
    bottom: float = PANEL_BOTTOM  # [m] z of the lower edge
    path: Tuple[Waypoint, ...] = ()  # it moves along these, straight from one to the next, and then begins again

    def at(self, time: float) -> 'Panel':
        """Return the panel where it is ``time`` [s] after the start of its world."""
        if not self.path:
            return self
        time = time % self.path[-1][0] if self.path[-1][0] > 0.0 else 0.0
        after = max(1, bisect.bisect_right([waypoint[0] for waypoint in self.path], time))
        (start, *old), (end, *new) = self.path[after - 1], self.path[min(after, len(self.path) - 1)]
        part = (time - start) / (end - start) if end > start else 0.0
        turn = wrap_angle(new[2] - old[2])  # the shorter way
        return self._replace(x=old[0] + part * (new[0] - old[0]), y=old[1] + part * (new[1] - old[1]),
                             yaw=wrap_angle(old[2] + part * turn))

    def board(self) -> Box:
        """Return the panel's body."""
        half = PANEL_THICKNESS / 2.0
        return Box(self.name, self.x + half * math.cos(self.yaw), self.y + half * math.sin(self.yaw), self.yaw,
                   PANEL_THICKNESS, self.size, self.size, self.bottom, (255, 255, 255))


Solid = Union[Box, Cylinder]
Shape = Union[Box, Cylinder, Panel]


class FloorPlan(NamedTuple):
    """All shapes of a world; their names are unique. ``check`` refuses impossible ones."""

    boxes: Tuple[Box, ...] = ()
    cylinders: Tuple[Cylinder, ...] = ()
    panels: Tuple[Panel, ...] = ()
    ground_colour: Colour = GROUND_COLOUR
    sky_colour: Colour = SKY_COLOUR

    def shapes(self) -> Tuple[Shape, ...]:
        """Return all shapes, boxes first, then cylinders, then panels."""
        return (*self.boxes, *self.cylinders, *self.panels)

    def solids(self) -> Tuple[Solid, ...]:
        """Return everything that a camera sees: boxes, cylinders, and the boards of the panels."""
        return (*self.boxes, *self.cylinders, *(panel.board() for panel in self.panels))

    def bodies(self) -> Tuple[Solid, ...]:
        """Return everything that stops a robot or a laser's ray: all solids but panels that move, as in Gazebo."""
        return (*self.boxes, *self.cylinders, *(panel.board() for panel in self.panels if not panel.path))

    def outlines(self, height: float) -> List[List[Tuple[float, float]]]:
        """Return the outlines [(x, y), ...] [m] of the bodies that a scanner at ``height`` [m] sees."""
        return [corners(body) if isinstance(body, Box) else _circle(body) for body in self.bodies()
                if body.bottom <= height < body.bottom + body.height]

    def moving(self) -> Tuple[Panel, ...]:
        """Return the panels that move by themselves."""
        return tuple(panel for panel in self.panels if panel.path)

    def at(self, time: float) -> 'FloorPlan':
        """Return the plan with all panels where they are ``time`` [s] after the start."""
        return self._replace(panels=tuple(panel.at(time) for panel in self.panels)) if self.moving() else self

    def with_panel(self, name: str, x: float, y: float, yaw: float) -> 'FloorPlan':
        """Return the plan with the panel ``name`` moved to (x, y) [m], yaw [rad]; InvalidInput if there is none."""
        require_sane(f'the panel {name!r}', x=x, y=y, yaw=yaw)
        if all(panel.name != name for panel in self.panels):
            known = ', '.join(panel.name for panel in self.panels) or 'none'
            raise InvalidInput(f'there is no panel {name!r}; the panels are: {known}')
        if any(panel.name == name for panel in self.moving()):
            raise InvalidInput(f'the panel {name!r} moves by itself, along its path')
        return self._replace(panels=tuple(panel._replace(x=x, y=y, yaw=yaw) if panel.name == name else panel
                                          for panel in self.panels))

    def with_moved(self, poses: Sequence[Tuple[float, float, float]]) -> 'FloorPlan':
        """Return the plan with its ``moving`` panels at these poses (x, y, yaw), in the same order."""
        placed = {panel.name: panel._replace(x=x, y=y, yaw=yaw) for panel, (x, y, yaw) in zip(self.moving(), poses)}
        return self._replace(panels=tuple(placed.get(panel.name, panel) for panel in self.panels))

    def check(self) -> None:
        """Raise InvalidInput for the first impossible shape; the text names the shape and the field."""
        number = len(self.shapes())
        if number > MAX_SHAPES:
            raise InvalidInput(f'there are {number} shapes; at most {MAX_SHAPES} are allowed')
        names = set()
        for shape in self.shapes():
            _check_shape(shape)
            if shape.name in names:
                raise InvalidInput(f'{shape.name}: the name is used twice')
            names.add(shape.name)
        _check_colour('ground_colour', self.ground_colour)
        _check_colour('sky_colour', self.sky_colour)

    def overlaps(self, tolerance: float = TOUCHING) -> List[Tuple[str, str, float]]:
        """Return [(name, name, depth [m])] of the boxes and cylinders that overlap by more than ``tolerance`` [m]."""
        solids: Tuple[Solid, ...] = (*self.boxes, *self.cylinders)
        found = []
        for index, shape in enumerate(solids):
            for other in solids[index + 1:]:
                depth = _shared_depth(shape, other)
                if depth > tolerance:
                    found.append((shape.name, other.name, depth))
        return found


EMPTY = FloorPlan()


def _check_shape(shape: Shape) -> None:
    for field, value in zip(shape._fields, shape):
        if field == 'name':
            if not isinstance(value, str) or not 0 < len(value) <= MAX_NAME_LENGTH:
                raise InvalidInput(f'{shown(value)}: a name must have 1 to {MAX_NAME_LENGTH} characters')
        elif field == 'colour':
            _check_colour(f'{shape.name}: colour', value)
        elif field == 'path':
            _check_path(shape.name, value)
        elif field == 'marker_id':
            if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= LARGEST_MARKER_ID:
                raise InvalidInput(f'{shape.name}: marker_id is {shown(value)}; it must be a whole number from 0 to '
                                   f'{LARGEST_MARKER_ID}')
        else:
            _check_length(shape.name, field, value)
    if isinstance(shape, Panel) and shape.marker_size > shape.size:
        raise InvalidInput(f'{shape.name}: marker_size is {shape.marker_size:g}; the panel has only {shape.size:g} m')


def _check_path(name: str, path: Any) -> None:
    if not isinstance(path, (tuple, list)) or len(path) > MAX_WAYPOINTS:
        raise InvalidInput(f'{name}: path is {shown(path)}; it must be a list of at most {MAX_WAYPOINTS} waypoints')
    last = 0.0
    for index, waypoint in enumerate(path):
        where = f'path[{index}]'
        if not isinstance(waypoint, (tuple, list)) or len(waypoint) != 4:
            raise InvalidInput(f'{name}: {where} is {shown(waypoint)}; it must be [time, x, y, yaw]')
        for field, value in zip(('time', 'x', 'y', 'yaw'), waypoint):
            _check_length(name, f'{where}: {field}', value)
        if waypoint[0] < last or index == 0 and waypoint[0] != 0.0:
            raise InvalidInput(f'{name}: {where}: time is {waypoint[0]:g} s; the first must be 0, and each at least '
                               'that of the one before')
        last = waypoint[0]


def _check_length(name: str, field: str, value: Any) -> None:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) < math.inf:
        raise InvalidInput(f'{name}: {field} is {shown(value)}; it must be a finite number')
    if abs(value) > LARGEST:
        raise InvalidInput(f'{name}: {field} is {shown(value)}; it must be at most {LARGEST:g}')
    if field in ('length', 'width', 'height', 'radius', 'size', 'marker_size') and value <= 0.0:
        raise InvalidInput(f'{name}: {field} is {value:g}; it must be above 0')
    if field == 'bottom' and value < 0.0:
        raise InvalidInput(f'{name}: bottom is {value:g}; it must be at least 0, the floor')


def _check_colour(name: str, colour: Any) -> None:
    if (not isinstance(colour, (tuple, list)) or len(colour) != 3
            or any(isinstance(part, bool) or not isinstance(part, int) or not 0 <= part <= 255 for part in colour)):
        raise InvalidInput(f'{name} is {shown(colour)}; it must be three whole numbers from 0 to 255: red, green, blue')


def _shared_depth(shape: Solid, other: Solid) -> float:
    """Return the smallest distance [m] by which two solids must move to be apart; 0 or less if they are."""
    depth = min(shape.bottom + shape.height, other.bottom + other.height) - max(shape.bottom, other.bottom)
    for axis_x, axis_y in _separating_axes(shape, other):
        low, high = _extent(shape, axis_x, axis_y)
        other_low, other_high = _extent(other, axis_x, axis_y)
        depth = min(depth, high - other_low, other_high - low)
        if depth <= 0.0:
            break
    return depth


def _separating_axes(shape: Solid, other: Solid) -> Iterator[Tuple[float, float]]:
    """Yield unit vectors; if there is a gap between the two convex outlines, one of these axes shows it."""
    for box in (shape, other):
        if isinstance(box, Box):
            cos, sin = math.cos(box.yaw), math.sin(box.yaw)
            yield cos, sin
            yield -sin, cos
    for round_shape, second in ((shape, other), (other, shape)):
        if isinstance(round_shape, Cylinder):
            points = [(second.x, second.y)] if isinstance(second, Cylinder) else corners(second)
            for x, y in points:
                distance = math.hypot(x - round_shape.x, y - round_shape.y)
                if distance > 0.0:
                    yield (x - round_shape.x) / distance, (y - round_shape.y) / distance


def corners(box: Box) -> List[Tuple[float, float]]:
    """Return the four corners [(x, y)] [m] of a box's outline, counter-clockwise from its own (+x, +y) corner."""
    cos, sin = math.cos(box.yaw), math.sin(box.yaw)
    return [(box.x + cos * a - sin * b, box.y + sin * a + cos * b)
            for a, b in ((box.length / 2.0, box.width / 2.0), (-box.length / 2.0, box.width / 2.0),
                         (-box.length / 2.0, -box.width / 2.0), (box.length / 2.0, -box.width / 2.0))]


def _circle(cylinder: Cylinder) -> List[Tuple[float, float]]:
    angles = [2.0 * math.pi * corner / CIRCLE for corner in range(CIRCLE)]
    return [(cylinder.x + cylinder.radius * math.cos(angle), cylinder.y + cylinder.radius * math.sin(angle))
            for angle in angles]


def _extent(shape: Solid, axis_x: float, axis_y: float) -> Tuple[float, float]:
    if isinstance(shape, Cylinder):
        middle = shape.x * axis_x + shape.y * axis_y
        return middle - shape.radius, middle + shape.radius
    along = [x * axis_x + y * axis_y for x, y in corners(shape)]
    return min(along), max(along)
