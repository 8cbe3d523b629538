"""The format of turtlesim's recordings: the events of each tick, and the poses. replay.py reads it.

A recording is a CSV file, one row a tick: ``tick, event, x, y, theta, linear_velocity, angular_velocity, r, g, b``
and here ``callers``. Pose and colour sensor are those of turtle1 after the tick, empty while there is no turtle1.
``event`` lists what took effect in the tick, separated by ``;``: one of EVENTS below each, with its values in the
units of turtlesim's messages; events of other turtles begin with their name: ``turtle2/cmd 1 0 0``. ``callers`` are
the nodes that asked for the events, in the same order.
"""
from typing import Callable, Dict, Iterable, Sequence

from kinematic_core.worlds.turtle_world import BACKGROUND, TurtlePose, float32
from turtlesim.core.drawn_world import DrawnWorld, Reading

TURTLE = 'turtle1'
COLOUR = ('r', 'g', 'b')
COLUMNS = (*TurtlePose._fields, *COLOUR)
EMPTY = ('',) * len(COLUMNS)


def _clear(drawn: DrawnWorld, _: str, *colour: float) -> None:
    r, g, b = map(int, colour or BACKGROUND)
    drawn.canvas.fill((r, g, b))


def _reset(drawn: DrawnWorld, turtle: str, *colour: float) -> None:
    drawn.reset()
    _clear(drawn, turtle, *colour)


def _start(drawn: DrawnWorld, _: str, x: float, y: float, theta: float) -> None:
    drawn.world.start = x, y, theta
    drawn.world.reset()


EVENTS: Dict[str, Callable[..., object]] = {  # name: function of (DrawnWorld, turtle, its values)
    'cmd': lambda drawn, turtle, vx, vy, wz: drawn.world.command(turtle, vx, vy, wz),
    'pen': lambda drawn, turtle, r, g, b, width, off: drawn.world.set_pen(turtle, *map(int, (r, g, b, width, off))),
    'teleport_absolute': lambda drawn, turtle, x, y, theta: drawn.world.teleport_absolute(turtle, x, y, theta),
    'teleport_relative': lambda drawn, turtle, linear, angular: drawn.world.teleport_relative(turtle, linear, angular),
    'timeout': lambda drawn, turtle: drawn.world.turtles[turtle].stop(),
    'clear': _clear,  # to the colour r, g, b, or to turtlesim's own
    'reset': _reset,  # the same
    'start': _start,  # where turtle1 starts, x, y, theta; from a new world on
    'spawn': lambda drawn, turtle, x, y, theta: drawn.world.spawn(x, y, theta, turtle),
    'kill': lambda drawn, turtle: drawn.world.kill(turtle),
}


def event_name(event: str, turtle: str) -> str:
    """Return the name that an event of EVENTS for this turtle has in a recording."""
    return event if turtle == TURTLE else f'{turtle}/{event}'


def fields(readings: Iterable[Reading]) -> Sequence[object]:
    """Return the values of COLUMNS in a row, from the result of DrawnWorld.step."""
    for turtle, colour, _ in readings:
        if turtle.name == TURTLE:
            return (*(f'{float32(value):.9g}' for value in turtle.pose()), *colour)
    return EMPTY
