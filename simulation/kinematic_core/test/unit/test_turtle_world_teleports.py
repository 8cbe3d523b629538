"""kinematic_core.worlds.turtle_world: teleports and pens, with values derived by hand."""
import math

import pytest

from kinematic_core.worlds.turtle_world import ARENA_SIZE, PEN_COLOUR, PEN_WIDTH, TurtleWorld, float32

CENTRE = ARENA_SIZE / 2.0
T = 'turtle1'
POSITION_TOLERANCE = 1e-9  # 1 nm: roundings of doubles
REQUEST_TOLERANCE = 3e-7  # [m or rad] of a service's float32 fields
RED = (255, 0, 0)


@pytest.fixture
def world():
    return TurtleWorld()


def test_absolute_teleport_takes_effect_in_the_next_step_and_draws_from_new_to_old(world):
    world.teleport_absolute(T, 2.0, 3.0, 1.5)
    assert world.turtles[T].pose() == (CENTRE, CENTRE, 0.0, 0.0, 0.0)
    (advance,) = world.step()
    assert advance.turtle.pose() == (2.0, 3.0, 1.5, 0.0, 0.0)
    assert advance.teleports == ((2.0, ARENA_SIZE - 3.0, CENTRE, CENTRE, PEN_COLOUR, PEN_WIDTH),)
    assert advance.stroke is None
    (advance,) = world.step()
    assert advance.teleports == ()


@pytest.mark.parametrize('theta, linear, angular, x, y', [
    (0.0, 2.0, math.pi / 2.0, 5.0, 7.0),  # turns first, then goes straight up
    (0.0, -2.0, math.pi / 2.0, 5.0, 3.0),
    (math.pi / 2.0, 1.5, 0.0, 5.0, 6.5),
    (math.pi / 2.0, 1.5, math.pi / 6.0, 4.25, 5.0 + 0.75 * math.sqrt(3.0)),  # 90 + 30 deg: cos = -1/2
    (0.5, 0.0, 1.0, 5.0, 5.0),
])
def test_relative_teleport_turns_then_moves(world, theta, linear, angular, x, y):
    world.teleport_absolute(T, 5.0, 5.0, theta)
    world.step()
    world.teleport_relative(T, linear, angular)
    (advance,) = world.step()
    assert advance.turtle.pose() == pytest.approx((x, y, theta + angular, 0.0, 0.0), abs=REQUEST_TOLERANCE)
    (stroke,) = advance.teleports
    assert stroke[:4] == pytest.approx((x, ARENA_SIZE - y, 5.0, ARENA_SIZE - 5.0), abs=REQUEST_TOLERANCE)


def test_fields_of_teleports_are_rounded_to_float32(world):
    world.teleport_absolute(T, 0.1, 0.7, 0.3)
    world.step()
    turtle = world.turtles[T]
    assert (turtle.x, turtle.y_down, turtle.theta) == (float32(0.1), ARENA_SIZE - float32(0.7), float32(0.3))
    world.teleport_relative(T, 0.1, 0.2)
    world.step()
    theta = float32(0.3) + float32(0.2)
    assert turtle.theta == theta
    assert turtle.x == float32(0.1) + math.cos(theta) * float32(0.1)
    assert turtle.y_down == ARENA_SIZE - float32(0.7) - math.sin(theta) * float32(0.1)


def test_teleports_of_one_step_run_in_the_order_in_which_they_came(world):
    world.teleport_absolute(T, 2.0, 2.0, 0.0)
    world.teleport_relative(T, 1.0, 0.0)
    world.teleport_absolute(T, 4.0, 4.0, 0.0)
    world.teleport_relative(T, -0.5, 0.0)
    (advance,) = world.step()
    # (2, 2), + 1 m = (3, 2), (4, 4), - 0.5 m = (3.5, 4)
    assert advance.turtle.pose()[:2] == (3.5, 4.0)
    path = [(CENTRE, CENTRE), (2.0, ARENA_SIZE - 2.0), (3.0, ARENA_SIZE - 2.0), (4.0, ARENA_SIZE - 4.0),
            (3.5, ARENA_SIZE - 4.0)]
    assert [stroke[:4] for stroke in advance.teleports] == [new + old for old, new in zip(path, path[1:])]


def test_motion_of_the_step_goes_on_from_the_teleports_target(world):
    world.command(T, 1.0, 0.0, 0.0)
    world.teleport_absolute(T, 2.0, 2.0, 0.0)
    (advance,) = world.step()
    assert advance.turtle.pose()[:2] == pytest.approx((2.016, 2.0), abs=POSITION_TOLERANCE)
    assert advance.stroke[:4] == pytest.approx((2.016, ARENA_SIZE - 2.0, 2.0, ARENA_SIZE - 2.0))


def test_absolute_teleport_above_the_arena_stays_at_the_upper_edge_without_a_wall(world):
    world.teleport_absolute(T, 5.0, 20.0, 0.0)  # y down would be -8.9: not below 0
    (advance,) = world.step()
    assert advance.wall is None
    assert advance.teleports[0][:2] == (5.0, 0.0)
    assert advance.turtle.y_down == 0.0


@pytest.mark.parametrize('x, y', [(-4.0, 5.0), (15.0, 5.0), (5.0, -3.0)])
def test_other_teleports_out_of_the_arena_draw_to_the_target_then_clamp(world, x, y):
    world.teleport_absolute(T, x, y, 0.0)
    (advance,) = world.step()
    assert advance.teleports[0][:2] == (x, ARENA_SIZE - y)
    assert advance.wall == (x, ARENA_SIZE - y)
    inside = (min(max(x, 0.0), ARENA_SIZE), ARENA_SIZE - max(y, 0.0))
    assert (advance.turtle.x, advance.turtle.y_down) == inside
    assert advance.stroke[:4] == inside + (x, ARENA_SIZE - y)  # the clamping is a motion, too
    (advance,) = world.step()
    assert (advance.teleports, advance.wall, advance.stroke) == ((), None, None)


def test_pen_takes_effect_at_once_and_colours_strokes_to_come(world):
    world.teleport_absolute(T, 2.0, 2.0, 0.0)
    world.set_pen(T, 255, 0, 0, 7, False)  # before the step in which the teleport draws
    world.command(T, 1.0, 0.0, 0.0)
    (advance,) = world.step()
    assert [stroke[4:] for stroke in advance.teleports + (advance.stroke,)] == [(RED, 7), (RED, 7)]


def test_pen_up_draws_nothing_and_keeps_colour_and_width(world):
    world.set_pen(T, 255, 0, 0, 7, False)
    world.set_pen(T, 1, 2, 3, 4, True)
    world.teleport_absolute(T, 2.0, 2.0, 0.0)
    world.command(T, 1.0, 0.0, 0.0)
    (advance,) = world.step()
    assert (advance.teleports, advance.stroke) == ((), None)
    assert (advance.turtle.pen_colour, advance.turtle.pen_width) == (RED, 7)
    world.set_pen(T, 0, 255, 0, 2, 0)
    (advance,) = world.step()
    assert advance.stroke[4:] == ((0, 255, 0), 2)


@pytest.mark.parametrize('asked, drawn', [(0, 1), (1, 1), (2, 2), (255, 255)])
def test_pen_width_0_means_1(world, asked, drawn):
    world.set_pen(T, 0, 255, 128, asked, 0)
    world.command(T, 1.0, 0.0, 0.0)
    (advance,) = world.step()
    assert advance.stroke[4:] == ((0, 255, 128), drawn)
