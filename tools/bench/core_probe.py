"""Turtle ticks per second of the turtle world, alone and with its canvas: a probe without ROS (see probing.py).

The turtles drive circles with their pens on; the time includes the commands that keep them moving (one within the
watchdog's second), as in a node.
"""
import math
import time

from kinematic_core.worlds.turtle_world import TurtleWorld
from probing import say
from turtlesim.core.drawn_world import DrawnWorld

COMMAND_EVERY = 50  # steps: 0.8 s, inside the watchdog's second
COUNTS = (1, 100)


def ticks_per_second(world, step, count, seconds):
    """Return the turtle ticks per second of ``count`` turtles, over at least ``seconds`` of step() of ``world``."""
    for number in range(count - 1):
        world.spawn(1.5 + 0.8 * (number % 10), 1.5 + 0.8 * (number // 10 % 10), 0.7 * number)
    steps, begun, elapsed = 0, time.perf_counter(), 0.0
    while elapsed < seconds:
        for number, name in enumerate(sorted(world.turtles)):  # circles of 0.5 to 1 m radius, each a little different
            world.command(name, 1.0 + 0.01 * (number % 100), 0.0, 2.0)
        for _ in range(COMMAND_EVERY):
            step()
        steps += COMMAND_EVERY
        elapsed = time.perf_counter() - begun
    if not all(math.hypot(turtle.linear_x, turtle.linear_y) for turtle in world.turtles.values()):
        raise RuntimeError('a turtle does not move, so the figures would be too good')
    return count * steps / elapsed


def ticks(seconds):
    """Report each figure, measured for this time."""
    found = {}
    for count in COUNTS:
        world = TurtleWorld()
        found[f'core_{count}'] = ticks_per_second(world, world.step, count, seconds)
        drawn = DrawnWorld()
        found[f'canvas_{count}'] = ticks_per_second(drawn.world, drawn.step, count, seconds)
    say(**found)
