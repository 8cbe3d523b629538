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


def fill(world, count):
    """Spawn turtles in a grid until there are ``count``; return their names."""
    for number in range(count - 1):
        world.spawn(1.5 + 0.8 * (number % 10), 1.5 + 0.8 * (number // 10 % 10), 0.7 * number)
    return sorted(world.turtles)


def command_all(world, names):
    """Command all turtles to drive circles of 0.5 m to 1 m radius, each a little different."""
    for number, name in enumerate(names):
        world.command(name, 1.0 + 0.01 * (number % 100), 0.0, 2.0)


def ticks_per_second(world, step, count, seconds):
    """Return the turtle ticks per second of ``count`` turtles, over at least ``seconds`` of step() of ``world``."""
    names = fill(world, count)
    steps = 0
    begun = time.perf_counter()
    while True:
        command_all(world, names)
        for _ in range(COMMAND_EVERY):
            step()
        steps += COMMAND_EVERY
        elapsed = time.perf_counter() - begun
        if elapsed >= seconds:
            return count * steps / elapsed


def require_moving(world):
    """Raise RuntimeError if a turtle stands still: its ticks take less time than those to measure."""
    resting = [name for name, turtle in world.turtles.items() if math.hypot(turtle.linear_x, turtle.linear_y) == 0.0]
    if resting:
        raise RuntimeError(f'{len(resting)} of {len(world.turtles)} turtles do not move; the figures would be too good')


def ticks(seconds):
    """Report each figure, measured for this time."""
    found = {}
    for count in COUNTS:
        world = TurtleWorld()
        found[f'core_{count}'] = ticks_per_second(world, world.step, count, seconds)
        require_moving(world)
        drawn = DrawnWorld()
        found[f'canvas_{count}'] = ticks_per_second(drawn.world, drawn.step, count, seconds)
        require_moving(drawn.world)
    say(**found)
