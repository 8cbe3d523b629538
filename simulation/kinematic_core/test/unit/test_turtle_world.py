"""kinematic_core.worlds.turtle_world: motion, watchdog and walls, with values derived by hand."""
import math

import pytest

from kinematic_core.worlds.turtle_world import (
    ARENA_SIZE,
    BACKGROUND,
    DT,
    PEN_COLOUR,
    PEN_WIDTH,
    PIXELS_PER_METRE,
    TURTLESIM_PI,
    WATCHDOG,
    WATCHDOG_STEPS,
    TurtleWorld,
    float32,
)

CENTRE = ARENA_SIZE / 2.0
T = 'turtle1'
POSITION_TOLERANCE = 1e-9  # 1 nm: roundings of doubles
ANGLE_TOLERANCE = 1e-9  # [rad]


@pytest.fixture
def world():
    return TurtleWorld()


def run(world, steps):
    """Step and return the last Advance of every turtle."""
    for _ in range(steps):
        advances = world.step()
    return advances


def placed(world, x, y, theta=0.0):
    """Put turtle1 somewhere, with its pen up on the way."""
    world.set_pen(T, 0, 0, 0, 0, True)
    world.teleport_absolute(T, x, y, theta)
    world.step()
    world.set_pen(T, *PEN_COLOUR, PEN_WIDTH, False)
    return world.turtles[T]


def test_constants_are_those_of_the_real_turtlesim():
    # 499 px / 45 px/m = 11.08888.., as float32 11.0888891220092773 (9 digits say which float32 it is)
    assert f'{ARENA_SIZE:.9g}' == '11.0888891'
    assert f'{float32(CENTRE):.9g}' == '5.54444456'
    assert (DT, PIXELS_PER_METRE, PEN_COLOUR, PEN_WIDTH) == (0.016, 45.0, (179, 184, 255), 3)
    assert BACKGROUND == (69, 86, 255)


@pytest.mark.parametrize('value, rounded', [
    (0.5, 0.5),
    (0.1, 0.100000001490116119384765625),  # 13421773 / 2^27
    (3.14, 3.1400001049041748046875),
    (16777217.0, 16777216.0),  # 2^24 + 1 is the first integer that float32 lacks
])
def test_float32_rounds_as_a_message_field(value, rounded):
    assert float32(value) == rounded


def test_begins_with_turtle1_at_rest_in_the_middle_with_its_pen_down(world):
    assert list(world.turtles) == [T]
    turtle = world.turtles[T]
    assert turtle.pose() == (CENTRE, CENTRE, 0.0, 0.0, 0.0)
    assert (turtle.pen_on, turtle.pen_colour, turtle.pen_width) == (True, PEN_COLOUR, PEN_WIDTH)
    assert world.steps == 0


def test_one_step_is_16_ms_of_motion_and_is_counted(world):
    world.command(T, 1.0, 0.0, 0.0)
    (advance,) = world.step()
    assert world.steps == 1
    assert advance.turtle is world.turtles[T]
    assert advance.turtle.pose() == pytest.approx((CENTRE + 0.016, CENTRE, 0.0, 1.0, 0.0), abs=POSITION_TOLERANCE)
    run(world, 9)
    assert world.steps == 10
    assert advance.turtle.x == pytest.approx(CENTRE + 0.16, abs=POSITION_TOLERANCE)


@pytest.mark.parametrize('theta, linear_x, linear_y, dx, dy', [
    (0.0, 2.0, 0.0, 2.0, 0.0),
    (0.0, -2.0, 0.0, -2.0, 0.0),
    (0.0, 0.0, 2.0, 0.0, 2.0),  # linear.y is to the left: the turtle is holonomic
    (math.pi / 2.0, 2.0, 0.0, 0.0, 2.0),  # heading up
    (math.pi / 2.0, 0.0, 2.0, -2.0, 0.0),  # heading up, left is -x
    (-math.pi / 2.0, 1.0, 3.0, 3.0, -1.0),  # heading down, left is +x
    (math.pi / 4.0, 1.0, 1.0, 0.0, math.sqrt(2.0)),
    (3.0, 0.0, 0.0, 0.0, 0.0),
])
def test_velocities_are_in_the_turtles_frame(world, theta, linear_x, linear_y, dx, dy):
    turtle = placed(world, 5.0, 5.0, theta)
    world.command(T, linear_x, linear_y, 0.0)
    world.step()
    heading_rounding = 2e-7 * DT  # [m] theta came as a float32
    assert turtle.x - 5.0 == pytest.approx(dx * DT, abs=2.0 * heading_rounding)
    assert turtle.pose().y - 5.0 == pytest.approx(dy * DT, abs=2.0 * heading_rounding)
    # never negative: sqrt(vx^2 + vy^2)
    assert turtle.pose().linear_velocity == pytest.approx(math.hypot(linear_x, linear_y))


def test_heading_turns_before_the_turtle_moves_along_it(world):
    # at w = (pi / 2) / 0.016 the heading is straight up after one step, and the whole step goes up
    world.command(T, 1.0, 0.0, math.pi / 2.0 / DT)
    world.step()
    pose = world.turtles[T].pose()
    assert pose[:3] == pytest.approx((CENTRE, CENTRE + 0.016, math.pi / 2.0), abs=POSITION_TOLERANCE)
    assert pose.angular_velocity == math.pi / 2.0 / DT


def test_heading_wraps_with_turtlesims_pi(world):
    turtle = placed(world, 5.0, 5.0, 3.125)
    world.command(T, 0.0, 0.0, 2.0)
    world.step()
    # 3.125 + 0.032 = 3.157 > pi, so 2 * 3.14159265 less; with math.pi it would be 7.2e-9 rad lower
    assert turtle.theta == pytest.approx(3.157 - 6.2831853, abs=ANGLE_TOLERANCE)


@pytest.mark.parametrize('sent, heading', [
    (3.141592502593994, 3.141592502593994),  # the last float32 below TURTLESIM_PI
    (3.1415927410125732, 3.1415927410125732 - 2.0 * TURTLESIM_PI),  # float32(pi) lies above it
    (-3.1415927410125732, 2.0 * TURTLESIM_PI - 3.1415927410125732),
    (7.0, 7.0 - 2.0 * TURTLESIM_PI),
])
def test_heading_of_a_teleport_is_wrapped_in_the_same_step(world, sent, heading):
    world.teleport_absolute(T, 5.0, 5.0, sent)
    world.step()
    assert world.turtles[T].theta == heading


def test_last_of_several_commands_counts(world):
    world.command(T, 5.0, 5.0, 5.0)
    world.command(T, 1.0, 0.0, 0.0)
    world.step()
    assert world.turtles[T].pose() == pytest.approx((CENTRE + 0.016, CENTRE, 0.0, 1.0, 0.0), abs=POSITION_TOLERANCE)


@pytest.mark.parametrize('steps_before', [0, 1, 10, 100])
def test_a_command_lasts_exactly_63_steps(world, steps_before):
    # 62 * 0.016 s = 0.992 s is not more than 1 s, 63 * 0.016 s = 1.008 s is: step k + 63 is the first at rest
    assert (WATCHDOG, WATCHDOG_STEPS) == (1.0, 63)
    if steps_before:
        run(world, steps_before)
    world.command(T, 1.0, 0.0, 0.5)
    run(world, 63)
    moving = world.turtles[T].pose()
    assert moving[3:] == (1.0, 0.5)
    world.step()
    stopped = world.turtles[T].pose()
    assert stopped == (moving.x, moving.y, moving.theta, 0.0, 0.0)
    run(world, 200)
    assert world.turtles[T].pose() == stopped


def test_a_new_command_winds_the_watchdog_up_again(world):
    world.command(T, 0.1, 0.0, 0.0)
    run(world, 40)
    world.command(T, 0.1, 0.0, 0.0)
    run(world, 63)
    assert world.turtles[T].x == pytest.approx(CENTRE + 103 * 0.0016, abs=POSITION_TOLERANCE)
    run(world, 10)
    assert world.turtles[T].x == pytest.approx(CENTRE + 103 * 0.0016, abs=POSITION_TOLERANCE)


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


@pytest.mark.parametrize('linear_x, linear_y, x, y, wall', [
    # 100 m/s are 1.6 m a step, from (10, 10) or (1, 1); the wall says where the turtle would be, y down
    (100.0, 0.0, ARENA_SIZE, 10.0, (11.6, ARENA_SIZE - 10.0)),
    (0.0, 100.0, 10.0, ARENA_SIZE, (10.0, ARENA_SIZE - 11.6)),
    (100.0, 100.0, ARENA_SIZE, ARENA_SIZE, (11.6, ARENA_SIZE - 11.6)),
    (-100.0, 0.0, 0.0, 1.0, (-0.6, ARENA_SIZE - 1.0)),
    (0.0, -100.0, 1.0, 0.0, (1.0, ARENA_SIZE + 0.6)),
])
def test_walls_clamp_and_say_where_the_turtle_would_have_gone(world, linear_x, linear_y, x, y, wall):
    start = 10.0 if linear_x + linear_y > 0.0 else 1.0
    turtle = placed(world, start, start)
    world.command(T, linear_x, linear_y, 0.0)
    (advance,) = world.step()
    assert advance.wall == pytest.approx(wall, abs=POSITION_TOLERANCE)
    assert (turtle.x, turtle.pose().y) == pytest.approx((x, y), abs=POSITION_TOLERANCE)
    # the line ends at the wall: from the new position to the old one
    assert advance.stroke[:4] == pytest.approx((x, ARENA_SIZE - y, start, ARENA_SIZE - start))


def test_wall_is_reported_in_every_step_of_pushing_and_the_turtle_slides_along_it(world):
    placed(world, ARENA_SIZE, 5.0, 0.0)
    world.command(T, 1.0, 1.0, 0.0)
    for step in range(1, 64):
        (advance,) = world.step()
        assert advance.wall == pytest.approx((ARENA_SIZE + 0.016, ARENA_SIZE - 5.0 - step * 0.016), abs=1e-6)
        assert advance.turtle.x == ARENA_SIZE
    (advance,) = world.step()
    assert advance.wall is None


def test_wall_of_a_turtle_that_cannot_move_is_reported_without_a_stroke(world):
    placed(world, ARENA_SIZE, 5.0, 0.0)
    world.command(T, 1.0, 0.0, 0.0)
    for _ in range(63):
        (advance,) = world.step()
        assert advance.wall is not None
        assert advance.stroke is None
    assert world.turtles[T].pose().linear_velocity == 1.0  # the command, as in the real turtlesim


def test_edge_of_the_arena_itself_is_no_wall(world):
    for corner in ((0.0, 0.0), (ARENA_SIZE, ARENA_SIZE)):
        world.teleport_absolute(T, *corner, 0.0)
        (advance,) = world.step()
        assert advance.wall is None
        assert advance.turtle.pose()[:2] == corner


def test_turning_on_the_spot_draws_nothing(world):
    world.command(T, 0.0, 0.0, 2.0)
    for _ in range(63):
        (advance,) = world.step()
        assert advance.stroke is None


def test_heading_stays_in_range_for_100000_steps(world):
    turtle, rates = world.turtles[T], (31.0, -47.0, 0.37, -3.0, 200.0)  # [rad/s]
    for step in range(100_000):
        if step % 50 == 0:
            world.command(T, 0.0, 0.0, rates[step // 50 % len(rates)])
        world.step()
        assert -TURTLESIM_PI <= turtle.theta < TURTLESIM_PI
    assert world.steps == 100_000
