"""Records what a simulator does in the form that replay.py reads: what took effect in which tick, and the poses.

A recording is a CSV file, one row a tick: ``tick, event, x, y, theta, linear_velocity, angular_velocity, r, g, b``
and here ``callers``. Pose and colour sensor are those of turtle1 after the tick, empty while there is no turtle1.
``event`` is what took effect in the tick (several are separated by ``;``), of EVENTS below, with its values in the
units of turtlesim's messages; events of other turtles begin with their name: ``turtle2/cmd 1 0 0``. ``callers`` are
the nodes that asked for the events, in the same order.
"""
from kinematic_core.timing import recorder
from kinematic_core.worlds.turtle_world import BACKGROUND, TurtlePose, float32

TURTLE = 'turtle1'
COLOUR = ('r', 'g', 'b')
EMPTY = ('',) * (len(TurtlePose._fields) + len(COLOUR))


def _clear(drawn, _, *colour):
    r, g, b = map(int, colour or BACKGROUND)
    drawn.canvas.fill((r, g, b))


def _reset(drawn, turtle, *colour):
    drawn.reset()
    _clear(drawn, turtle, *colour)


def _start(drawn, _, x, y, theta):
    drawn.world.start = x, y, theta
    drawn.world.reset()


EVENTS = {  # name: what it does to (DrawnWorld, turtle, its values)
    'cmd': lambda drawn, turtle, vx, vy, wz: drawn.world.command(turtle, vx, vy, wz),
    'pen': lambda drawn, turtle, r, g, b, width, off: drawn.world.set_pen(turtle, *map(int, (r, g, b, width, off))),
    'teleport_absolute': lambda drawn, turtle, x, y, theta: drawn.world.teleport_absolute(turtle, x, y, theta),
    'teleport_relative': lambda drawn, turtle, linear, angular: drawn.world.teleport_relative(turtle, linear, angular),
    'timeout': lambda drawn, turtle: drawn.world.turtles[turtle].stop(),
    'clear': _clear,  # to the colour r, g, b, or to turtlesim's own
    'reset': _reset,  # likewise
    'start': _start,  # where turtle1 begins, x, y, theta; from a new world on
    'spawn': lambda drawn, turtle, x, y, theta: drawn.world.spawn(x, y, theta, turtle),
    'kill': lambda drawn, turtle: drawn.world.kill(turtle),
}


class Recorder(recorder.Recorder):
    """Writes the recording of a DrawnWorld."""

    def __init__(self, path):
        """Begin the file; raise OSError when that cannot be."""
        super().__init__(path, (*TurtlePose._fields, *COLOUR))

    def note(self, event, *values, turtle=TURTLE, caller=''):
        """Keep an event, of EVENTS, for the next tick."""
        super().note(event if turtle == TURTLE else f'{turtle}/{event}', *values, caller=caller)

    def tick(self, number, readings):
        """Write the row of a tick from what DrawnWorld.step returned; raise OSError when it cannot be written."""
        reading = next((reading for reading in readings if reading[0].name == TURTLE), None)
        pose = () if reading is None else [f'{float32(value):.9g}' for value in reading[0].pose()]
        super().tick(number, EMPTY if reading is None else (*pose, *reading[1]))
