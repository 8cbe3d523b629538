"""The world of turtlesim in fixed steps of 16 ms: arena, turtles, teleports, pens, watchdog.

Every pose equals that of the node of ROS Noetic, bit by bit. Quantities:

=====================  =========================================================================
quantity               unit, range, frame
=====================  =========================================================================
x, y                   m, 0 .. ARENA_SIZE, origin in the lower left corner, y up
y_down                 m, ARENA_SIZE - y, as the world keeps it (the picture's y axis)
theta                  rad, [-pi, pi), counter-clockwise from +x
linear_x, linear_y     m/s, in the turtle's frame: forward and to the left
angular_z              rad/s, counter-clockwise
pen colour, width      (r, g, b) 0..255 each; width 1..255 px
=====================  =========================================================================

This module uses neither a clock nor ROS and draws nothing: strokes are returned as data, in drawing order. The class
is not thread-safe; threads that share a world need a lock.
"""
import bisect
import ctypes
import math
import random
from typing import Any, Callable, Collection, Dict, List, NamedTuple, Optional, Tuple

from kinematic_core.worlds.angles import wrap_angle
from plain_support import InvalidInput, require_sane

CANVAS_SIZE = 500  # [px] width and height of turtlesim's picture
PIXELS_PER_METRE = 45.0  # the height of turtlesim's turtle picture, which is its metre
DT = 0.016  # [s] one step
WATCHDOG = 1.0  # [s] without a command after which a turtle stops
WATCHDOG_STEPS = math.floor(WATCHDOG / DT) + 1  # the first step that lies more than WATCHDOG after the command's
TURTLESIM_PI = 3.14159265  # turtlesim's literal; math.pi gives other last bits

MAX_ECHO = 200  # [characters] of a name that an error text repeats
Colour = Tuple[int, int, int]  # (r, g, b), 0..255

BACKGROUND = (69, 86, 255)
PEN_COLOUR = (179, 184, 255)
PEN_WIDTH = 3  # [px]


def float32(value: float) -> float:
    """Round a number to the nearest float32, as a message field does."""
    return ctypes.c_float(value).value


ARENA_SIZE = float32((CANVAS_SIZE - 1) / PIXELS_PER_METRE)  # [m] 11.0888891, both directions
START = (ARENA_SIZE / 2.0, ARENA_SIZE / 2.0, 0.0)  # [m, m, rad] x, y, theta of turtle1
START_MARGIN = 2.0  # [m] between a random start and the walls


def random_start(seed: Any) -> Tuple[float, float, float]:
    """Return a random (x, y, theta) [m, m, rad]; the same seed gives the same."""
    numbers = random.Random(seed)
    low, high = START_MARGIN, ARENA_SIZE - START_MARGIN
    return numbers.uniform(low, high), numbers.uniform(low, high), numbers.uniform(-math.pi, math.pi)


class NameTaken(InvalidInput):
    """A turtle with that name already exists."""


class UnknownTurtle(InvalidInput):
    """There is no turtle with that name."""


class TurtlePose(NamedTuple):
    """The content of a turtlesim/Pose: x, y [m], theta [rad], speed [m/s, never negative], angular speed [rad/s]."""

    x: float
    y: float
    theta: float
    linear_velocity: float
    angular_velocity: float


class Stroke(NamedTuple):
    """A straight line of a pen: from the new position (x0, y0) to the old one (x1, y1), m, y down."""

    x0: float
    y0: float
    x1: float
    y1: float
    colour: Colour
    width: int  # [px] 1..255


class Advance(NamedTuple):
    """The effect of one step on one turtle. Its colour sensor reads between ``teleports`` and ``stroke``."""

    turtle: 'Turtle'
    teleports: Tuple[Stroke, ...]  # of this step's teleports
    wall: Optional[Tuple[float, float]]  # (x, y_down) [m] that was clamped to the arena
    stroke: Optional[Stroke]  # of this step's motion


class Turtle:
    """One turtle's state; made by TurtleWorld.spawn. Attributes as in the table of the module."""

    __slots__ = ('name', 'x', 'y_down', 'theta', 'linear_x', 'linear_y', 'angular_z', 'pen_on', 'pen_colour',
                 'pen_width', 'idle', '_teleports', '_stops_at')

    def __init__(self, name: str, x: float, y_down: float, theta: float) -> None:
        self.name = name
        self.x, self.y_down, self.theta = x, y_down, theta
        self.linear_x = self.linear_y = self.angular_z = 0.0
        self.pen_on, self.pen_colour, self.pen_width = True, PEN_COLOUR, PEN_WIDTH
        self.idle = False  # nothing changes until the next command or teleport
        self._teleports: List[Callable[[Turtle], None]] = []
        self._stops_at: Optional[float] = None  # the step at which the watchdog stops it

    def pose(self) -> TurtlePose:
        """Return the pose in double precision."""
        return TurtlePose(self.x, ARENA_SIZE - self.y_down, self.theta,
                          math.sqrt(self.linear_x * self.linear_x + self.linear_y * self.linear_y), self.angular_z)

    def stop(self) -> None:
        """Set all velocities to 0, as the watchdog does."""
        self.linear_x = self.linear_y = self.angular_z = 0.0
        self._stops_at = None

    def advance(self, step: int) -> Advance:
        """Move on by one step, the world's number ``step``."""
        teleports: Tuple[Stroke, ...] = self._run_teleports() if self._teleports else ()
        if self.idle:
            return Advance(self, teleports, None, None)
        if self._stops_at is not None and step >= self._stops_at:
            self.stop()
        old_x, old_y, old_theta = self.x, self.y_down, self.theta
        wall = self._integrate()
        stroke = None
        if self.x != old_x or self.y_down != old_y:
            if self.pen_on:
                stroke = Stroke(self.x, self.y_down, old_x, old_y, self.pen_colour, self.pen_width)
        elif self.theta == old_theta and self._stops_at is None:
            self.idle = True
        return Advance(self, teleports, wall, stroke)

    def _integrate(self) -> Optional[Tuple[float, float]]:
        """Update the heading first, then the position along the new heading; clamp at the walls, return where."""
        theta = wrap_angle(self.theta + self.angular_z * DT, TURTLESIM_PI)
        cos, sin = math.cos(theta), math.sin(theta)
        x = self.x + (cos * self.linear_x * DT - sin * self.linear_y * DT)
        y = self.y_down - (cos * self.linear_y * DT + sin * self.linear_x * DT)
        self.theta = theta
        wall = None
        if not (0.0 <= x <= ARENA_SIZE and 0.0 <= y <= ARENA_SIZE):
            wall = (x, y)
            x, y = min(max(x, 0.0), ARENA_SIZE), min(max(y, 0.0), ARENA_SIZE)
        self.x, self.y_down = x, y
        return wall

    def _run_teleports(self) -> Tuple[Stroke, ...]:
        strokes = []
        for teleport in self._teleports:
            old_x, old_y = self.x, self.y_down
            teleport(self)
            if self.pen_on:
                strokes.append(Stroke(self.x, self.y_down, old_x, old_y, self.pen_colour, self.pen_width))
        self._teleports.clear()
        self.idle = False
        return tuple(strokes)


class TurtleWorld:
    """Turtles in an arena of ARENA_SIZE x ARENA_SIZE.

    Commands given between two steps take effect in the next one: all teleports in their order, but only the last
    velocity command; the pen changes at once. Every method that takes values raises InvalidInput (or
    its subclasses NameTaken, UnknownTurtle) and changes nothing when it refuses them.
    """

    def __init__(self, watchdog_steps: float = WATCHDOG_STEPS, start: Tuple[float, float, float] = START) -> None:
        """Start with turtle1 at ``start``; a velocity command lasts ``watchdog_steps`` steps, which may be inf."""
        self.start = start  # x, y [m], theta [rad] of turtle1, now and after each reset
        self._watchdog_steps = watchdog_steps
        self.steps = 0  # done so far; the first has the number 0
        self.reset()

    def reset(self) -> None:
        """Remove all turtles, restart the numbering and spawn turtle1 at its start."""
        self.turtles: Dict[str, Turtle] = {}
        self._names: List[str] = []  # sorted
        self._order: List[Turtle] = []  # in the order of their names
        self._counter = 0
        self.spawn(*self.start)

    def next_name(self, taken: Collection[str] = ()) -> str:
        """Return the next automatic name that is not in ``taken``."""
        number = self._counter + 1
        while f'turtle{number}' in self.turtles or f'turtle{number}' in taken:
            number += 1
        return f'turtle{number}'

    def check_spawn(self, x: float, y: float, theta: float, name: str) -> None:
        """Raise InvalidInput if ``spawn`` would refuse these values."""
        require_sane('spawn', x=x, y=y, theta=theta)
        if name in self.turtles:
            # turtlesim's text, including its 'turtled'
            raise NameTaken(f'A turtled named [{name}] already exists; choose another name or leave it empty')

    def spawn(self, x: float, y: float, theta: float, name: str = '', taken: Collection[str] = ()) -> str:
        """Add a turtle at (x, y) [m, y up] with heading theta [rad], each rounded to float32; return its name.

        Without a name it gets the next free one of turtle1, turtle2, ... that is not in ``taken``.
        """
        self.check_spawn(x, y, theta, name)
        if not name:
            name = self.next_name(taken)
            self._counter = int(name[len('turtle'):])
        # the subtraction is one of float32 numbers in turtlesim, too
        turtle = Turtle(name, float32(x), float32(ARENA_SIZE - float32(y)), float32(theta))
        self.turtles[name] = turtle
        self._insert(turtle)
        return name

    def kill(self, name: str) -> None:
        """Remove a turtle; its strokes stay."""
        self._turtle(f'Tried to kill turtle [{name[:MAX_ECHO]}], which does not exist', name)
        self._names.remove(name)
        self._order.remove(self.turtles.pop(name))

    def command(self, name: str, linear_x: float, linear_y: float, angular_z: float) -> None:
        """Set a turtle's velocities [m/s, m/s, rad/s] and restart its watchdog."""
        turtle = self._turtle(f'cmd_vel of {name}: it does not exist', name)
        require_sane(f'cmd_vel of {name}', **{'linear.x': linear_x, 'linear.y': linear_y, 'angular.z': angular_z})
        turtle.linear_x, turtle.linear_y, turtle.angular_z = linear_x, linear_y, angular_z
        turtle._stops_at = self.steps + self._watchdog_steps
        turtle.idle = False

    def teleport_absolute(self, name: str, x: float, y: float, theta: float) -> None:
        """Put a turtle at (x, y) [m, y up] with heading theta [rad] in the next step; with the pen on it draws."""
        turtle = self._turtle(f'teleport_absolute of {name}: it does not exist', name)
        require_sane(f'teleport_absolute of {name}', x=x, y=y, theta=theta)
        x, y_down, theta = float32(x), max(0.0, ARENA_SIZE - float32(y)), float32(theta)

        def jump(moved: Turtle) -> None:
            moved.x, moved.y_down, moved.theta = x, y_down, theta
        turtle._teleports.append(jump)

    def teleport_relative(self, name: str, linear: float, angular: float) -> None:
        """Turn a turtle by angular [rad], then move it linear [m] along its new heading, in the next step."""
        turtle = self._turtle(f'teleport_relative of {name}: it does not exist', name)
        require_sane(f'teleport_relative of {name}', linear=linear, angular=angular)
        linear, angular = float32(linear), float32(angular)

        def jump(moved: Turtle) -> None:
            moved.theta += angular
            moved.x += math.cos(moved.theta) * linear
            moved.y_down += -math.sin(moved.theta) * linear
        turtle._teleports.append(jump)

    def set_pen(self, name: str, r: int, g: int, b: int, width: int, off: int) -> None:
        """Lift a turtle's pen if ``off``; else set it down with a colour, 0..255 each, and a width [px]; 0 means 1."""
        turtle = self._turtle(f'set_pen of {name}: it does not exist', name)
        for field, value in (('r', r), ('g', g), ('b', b), ('width', width)):
            if not 0 <= value <= 255:
                raise InvalidInput(f'set_pen of {name}: {field} is {value}; it must be 0 to 255')
        turtle.pen_on = not off
        if turtle.pen_on:
            turtle.pen_colour, turtle.pen_width = (r, g, b), width or 1

    def step(self) -> List[Advance]:
        """Advance by DT; return one Advance per turtle in alphabetical order, which is also the drawing order."""
        step = self.steps
        self.steps = step + 1
        return [turtle.advance(step) for turtle in self._order]

    def _turtle(self, complaint: str, name: str) -> Turtle:
        try:
            return self.turtles[name]
        except KeyError:
            raise UnknownTurtle(f'{complaint}; the turtles are: {", ".join(sorted(self.turtles)) or "none"}') from None

    def _insert(self, turtle: Turtle) -> None:
        """Insert a new turtle in order; sorting would take longer with every turtle."""
        index = bisect.bisect(self._names, turtle.name)
        self._names.insert(index, turtle.name)
        self._order.insert(index, turtle)
