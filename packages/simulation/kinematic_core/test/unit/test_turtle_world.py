"""kinematic_core.worlds.turtle_world: what test_turtle_world_reference.py does not ask for."""
import math

import pytest

from kinematic_core.worlds.turtle_world import ARENA_SIZE, TurtleWorld

T = 'turtle1'
CENTRE = ARENA_SIZE / 2.0
POSITION_TOLERANCE = 1e-9  # 1 nm: roundings of doubles


def run(world, steps):
    for _ in range(steps):
        world.step()


def test_another_watchdog_time_can_be_chosen_or_none_and_stop_does_what_it_does():
    short, endless = TurtleWorld(watchdog_steps=2), TurtleWorld(watchdog_steps=math.inf)
    for world in (short, endless):
        world.command(T, 0.1, 0.0, 0.0)
        run(world, 200)
    assert short.turtles[T].x == pytest.approx(CENTRE + 2 * 0.0016, abs=POSITION_TOLERANCE)
    assert endless.turtles[T].x == pytest.approx(CENTRE + 200 * 0.0016, abs=POSITION_TOLERANCE)
    endless.turtles[T].stop()
    x = endless.turtles[T].x
    run(endless, 3)
    assert endless.turtles[T].pose() == (x, CENTRE, 0.0, 0.0, 0.0)


@pytest.mark.parametrize('asked, drawn', [(0, 1), (1, 1), (7, 7), (255, 255)])
def test_pen_width_0_means_1_and_pen_up_keeps_colour_and_width(asked, drawn):
    world = TurtleWorld()
    world.set_pen(T, 255, 0, 0, asked, False)
    world.set_pen(T, 1, 2, 3, 4, True)
    assert (world.turtles[T].pen_colour, world.turtles[T].pen_width) == ((255, 0, 0), drawn)
