"""turtle_robotont.driving.control: speeds, limits, and drives closed over the simulated world."""
import itertools
import math
import random

import pytest

from kinematic_core.worlds.angles import wrap_angle
from kinematic_core.worlds.planar import Twist2D
from kinematic_core.worlds.turtle_world import ARENA_SIZE, DT
from turtle_robotont.driving import control
from turtle_robotont.driving.control import CircleDrive, DriveSequence, Goal, GoTo, State, Tolerance
from turtle_robotont.driving.shapes import InvalidInput, distance
from turtle_robotont.driving.vehicle import STOP, TURTLE, Limits, VehicleState

TOLERANCE = control.TOLERANCE
OVERSHOOT_TOLERANCE = 0.02  # [m] a turtle may move away from its goal again
CIRCLE_TOLERANCE = 0.01  # [m]
ROUNDING = 1e-9
DELAYS = (0, 1, 2, 3)  # poses, up to 48 ms


def random_drives(count, seed):
    """Return (start, Goal) pairs all over the arena."""
    numbers = random.Random(seed)

    def pose():
        return (numbers.uniform(0.0, ARENA_SIZE), numbers.uniform(0.0, ARENA_SIZE), numbers.uniform(-math.pi, math.pi))
    return [(pose(), Goal(*pose())) for _ in range(count)]


def heading_error(pose, goal):
    return abs(wrap_angle(goal.theta - pose.theta))


def standing(x=5.0, y=5.0, theta=0.0):
    return VehicleState(x, y, theta, 0.0, 0.0)


@pytest.mark.parametrize('left, speed', [
    (0.0, 0.0),
    (0.02, 0.14),  # close: 7 /s * 0.02 m
    (8.0 / 49.0, 8.0 / 7.0),  # the bend at a / k^2: both laws give a / k
    (0.5, 2.587),  # sqrt(2 * 8 * (0.5 - 4 / 49)) = sqrt(6.694)
    (4.0, 3.0),  # sqrt(62.7) = 7.9, cut to the top speed
])
def test_approach_speed_is_proportional_then_a_square_root_then_the_top_speed(left, speed):
    assert control.approach_speed(left, 3.0, deceleration=8.0, gain=7.0) == pytest.approx(speed, abs=1e-3)


def test_approach_speed_never_needs_more_than_the_deceleration():
    lefts = [i * 1e-4 for i in range(20000)]
    speeds = [control.approach_speed(left, 100.0, deceleration=8.0, gain=7.0) for left in lefts]
    for near, far, slow, fast in zip(lefts, lefts[1:], speeds, speeds[1:]):
        assert (fast ** 2 - slow ** 2) / (2.0 * (far - near)) <= 8.0 + ROUNDING


@pytest.mark.parametrize('command, cut', [
    (Twist2D(1.0, 0.0, -1.0), Twist2D(1.0, 0.0, -1.0)),
    (Twist2D(9.0, 0.0, 9.0), Twist2D(2.0, 0.0, 3.0)),
    (Twist2D(-9.0, 0.0, -9.0), Twist2D(-2.0, 0.0, -3.0)),
    (Twist2D(3.0, -4.0, 0.0), Twist2D(1.2, -1.6, 0.0)),  # 5 m/s, cut to two fifths in the same direction
])
def test_limits_cut_what_is_too_fast(command, cut):
    assert Limits(2.0, 3.0).apply(command) == pytest.approx(cut)


@pytest.mark.parametrize('x, y, theta', [(0.0, 0.0, None), (ARENA_SIZE, ARENA_SIZE, 0.0), (1.5, 2.5, -3.0)])
def test_goal_inside_the_arena_is_taken(x, y, theta):
    assert control.require_goal(x, y, theta) == pytest.approx(Goal(x, y, theta))


def test_heading_of_a_goal_is_wrapped():
    assert control.require_goal(1.0, 1.0, 7.0).theta == pytest.approx(7.0 - 2.0 * math.pi)


@pytest.mark.parametrize('x, y, theta, texts', [
    (math.nan, 1.0, 0.0, ["goal's x is nan", 'finite', '[m]']),
    (1.0, math.inf, 0.0, ["goal's y is inf", 'finite']),
    (1.0, 1.0, math.nan, ["goal's theta is nan", '[rad]']),
    (11.1, 1.0, None, ["goal's x is 11.1 m", '0 to 11.0889 m']),
    (1.0, -0.1, None, ["goal's y is -0.1 m", '0 to 11.0889 m']),
])
def test_refused_goal_is_named_with_what_is_allowed(x, y, theta, texts):
    with pytest.raises(InvalidInput) as refusal:
        control.require_goal(x, y, theta)
    for text in texts:
        assert text in str(refusal.value)


@pytest.mark.parametrize('delay', DELAYS)
def test_turtle_gets_to_any_goal_within_the_tolerance_and_stays(loop, delay):
    for start, goal in random_drives(60, seed=delay):
        run = loop(start, delay)
        drive = GoTo(run.pose, goal)
        run.run(drive)
        assert drive.state is State.ARRIVED and drive.reason == ''
        assert distance(run.pose, goal) <= TOLERANCE.position
        assert heading_error(run.pose, goal) <= TOLERANCE.heading
        distances = [distance(pose, goal) for pose in run.track]
        closest = distances.index(min(distances))
        assert max(distances[closest:]) <= OVERSHOOT_TOLERANCE


@pytest.mark.parametrize('limits', [Limits(0.1, 0.5), Limits(2.0, 0.1), Limits(1.0, 10.0), Limits(10.0, 10.0)])
def test_limits_hold_and_speed_is_gathered_gently(loop, limits):
    for start, goal in random_drives(5, seed=1):
        run = loop(start)
        drive = GoTo(run.pose, goal, limits)
        run.run(drive)
        assert drive.state is State.ARRIVED
        assert all(0.0 <= command.linear_x <= limits.speed for command in run.commands)
        assert all(abs(command.angular_z) <= limits.turn_speed for command in run.commands)
        gains = [b.linear_x - a.linear_x for a, b in zip(run.commands, run.commands[1:])]
        assert max(gains) <= TURTLE.acceleration * DT + ROUNDING


@pytest.mark.parametrize('goal', [
    Goal(0.0, 0.0), Goal(ARENA_SIZE, ARENA_SIZE, 0.0), Goal(0.0, ARENA_SIZE, math.pi / 2.0)])
def test_corners_of_the_arena_are_reached(loop, goal):
    run = loop()
    drive = GoTo(run.pose, goal)
    run.run(drive)
    assert drive.state is State.ARRIVED and distance(run.pose, goal) <= TOLERANCE.position


def test_states_follow_one_another(loop):
    run = loop((2.0, 2.0, 0.0))
    run.run(GoTo(run.pose, Goal(5.0, 6.0, -1.0)))
    assert [state for state, _ in itertools.groupby(run.states)] == [
        State.TURNING, State.DRIVING, State.ALIGNING, State.SETTLING, State.ARRIVED]


def test_turtle_that_is_there_already_does_not_move(loop):
    run = loop((3.0, 3.0, 1.0))
    drive = GoTo(run.pose, Goal(3.0, 3.0, 1.0))
    run.run(drive)
    assert drive.state is State.ARRIVED and set(run.commands) == {STOP}


def test_without_a_heading_the_turtle_keeps_the_one_it_came_with(loop):
    run = loop((2.0, 2.0, 0.0))
    run.run(GoTo(run.pose, Goal(2.0, 8.0)))
    assert run.pose.theta == pytest.approx(math.pi / 2.0, abs=0.1)


@pytest.mark.parametrize('missed', [1, 3, 6])
def test_lost_poses_do_not_keep_the_turtle_from_arriving(loop, missed):
    for start, goal in random_drives(10, seed=missed):
        run = loop(start, delay=0, missed=missed)
        drive = GoTo(run.pose, goal, Limits(1.0, 2.0))
        run.run(drive)
        assert drive.state is State.ARRIVED and distance(run.pose, goal) <= TOLERANCE.position


def test_drive_does_not_end_while_the_turtle_still_moves():
    drive = GoTo(standing(), Goal(5.0, 5.0))
    assert drive.step(VehicleState(5.0, 5.0, 0.0, 0.5, 0.0), DT) == STOP and drive.state is State.SETTLING
    assert drive.step(VehicleState(5.0, 5.0, 0.0, 0.0, -0.5), DT) == STOP and drive.state is State.SETTLING
    drive.step(standing(), DT)
    assert drive.state is State.ARRIVED


def test_turtle_pushed_away_while_it_settles_comes_back():
    drive = GoTo(standing(), Goal(5.0, 5.0))
    drive.step(VehicleState(5.0, 5.0, 0.0, 0.5, 0.0), DT)
    drive.step(standing(x=5.05), DT)
    assert drive.state is State.TURNING
    assert drive.step(standing(x=5.05), DT).angular_z != 0.0


def test_turtle_that_has_just_passed_its_goal_stays_there():
    drive = GoTo(standing(), Goal(5.0, 5.0))
    drive.step(standing(x=5.008), DT)
    assert drive.state is State.ARRIVED  # 8 of the 10 mm allowed: no turning back


def test_steering_fades_where_the_direction_says_little():
    drive = GoTo(standing(), Goal(5.1, 5.0))
    drive.step(standing(), DT)
    assert drive.state is State.DRIVING
    assert drive.step(standing(x=5.08, theta=-0.4), DT).angular_z == pytest.approx(4.0 * 0.4 * 0.02 / 0.1)


def test_turtle_that_others_press_against_a_wall_is_not_called_stuck():
    drive = GoTo(standing(), Goal(5.0, 5.0))
    pressed = VehicleState(5.0, 5.0, 0.0, 1.0, 0.0)
    while not drive.finished:
        drive.step(pressed, DT)
    assert 'not at the goal after' in drive.reason and 'another node' in drive.reason


def teleport_at(*times):
    """Return a disturbance that teleports the turtle to and fro at the given times [s]."""
    places, left = itertools.cycle([(9.0, 9.0), (1.0, 9.0)]), list(times)

    def disturb(loop):
        if left and loop.time >= left[0]:
            left.pop(0)
            loop.world.teleport_absolute('turtle1', *next(places), 0.0)
    return disturb


def test_teleported_turtle_drives_on_to_its_goal(loop):
    run = loop()
    drive = GoTo(run.pose, Goal(2.0, 2.0))
    run.run(drive, teleport_at(0.5, 1.0, 1.5))
    assert drive.state is State.ARRIVED and distance(run.pose, drive.goal) <= TOLERANCE.position


def test_turtle_teleported_too_often_gives_up(loop):
    run = loop()
    drive = GoTo(run.pose, Goal(2.0, 2.0))
    run.run(drive, teleport_at(0.5, 1.0, 1.5, 2.0))
    assert drive.state is State.FAILED and 'something else moved the turtle from (9' in drive.reason
    assert run.pose.linear_velocity == 0.0


def test_turtle_held_fast_is_stuck_after_two_seconds():
    drive = GoTo(standing(), Goal(9.0, 5.0))
    steps = 0
    while not drive.finished:
        drive.step(standing(), DT)
        steps += 1
    assert steps * DT == pytest.approx(control.STUCK_AFTER, abs=0.1)
    assert 'has not moved for 2 s' in drive.reason and '4.00 m left' in drive.reason


def test_turtle_that_somebody_else_drives_runs_into_the_deadline():
    drive = GoTo(standing(), Goal(9.0, 5.0), Limits(2.0, 4.0))
    times = itertools.count(1)
    while not drive.finished:
        time = next(times) * DT
        drive.step(VehicleState(5.0 + math.sin(time), 5.0 + math.cos(time), 0.0, 1.0, 1.0), DT)
    # 5 s + 2 * (4 m / 2 m/s + 2 pi rad / 4 rad/s) = 12.1 s
    assert drive.state is State.FAILED and 'not at the goal after 12.1 s' in drive.reason


def test_drive_ended_from_outside_sends_only_stops():
    drive = GoTo(standing(), Goal(9.0, 5.0))
    assert drive.step(standing(), DT) != STOP
    drive.end(State.PREEMPTED, 'a newer goal')
    assert drive.finished and drive.step(standing(), DT) == STOP
    assert (drive.state, drive.reason) == (State.PREEMPTED, 'a newer goal')


@pytest.mark.parametrize('delay', DELAYS)
@pytest.mark.parametrize('radius', [0.2, 1.0, 2.5])
def test_circle_is_round_and_closed(loop, radius, delay):
    run = loop((5.5, 2.0, 0.3), delay)
    start = run.pose
    drive = CircleDrive(start, radius)
    run.run(drive)
    assert drive.state is State.ARRIVED
    assert max(abs(distance(drive.centre, pose) - radius) for pose in run.track) <= CIRCLE_TOLERANCE
    assert distance(start, run.pose) <= CIRCLE_TOLERANCE + TOLERANCE.position
    assert sum(distance(a, b) for a, b in zip(run.track, run.track[1:])) == pytest.approx(
        2.0 * math.pi * radius, rel=0.05)


def test_teleport_ends_a_circle(loop):
    run = loop()
    drive = CircleDrive(run.pose, 1.0)
    run.run(drive, teleport_at(1.0))
    assert drive.state is State.FAILED and 'to (9.' in drive.reason


def legs(*goals):
    before, result = standing(5.5, 5.5), []
    for goal in goals:
        result.append(GoTo(before, goal, jumps_forgiven=0))
        before = goal
    return result


@pytest.mark.parametrize('delay', DELAYS)
def test_path_passes_its_goals_in_order(loop, delay):
    goals = [Goal(7.5, 5.5), Goal(7.5, 7.5), Goal(5.5, 5.5, 0.0)]
    run, drive, seen = loop(delay=delay), DriveSequence(legs(*goals)), []
    run.run(drive, lambda _: seen.append(drive.goal))
    assert drive.state is State.ARRIVED and distance(run.pose, goals[-1]) <= TOLERANCE.position
    assert [goal for goal, _ in itertools.groupby(seen)] == goals
    for goal in goals:
        assert min(distance(pose, goal) for pose in run.track) <= TOLERANCE.position


def test_path_ends_with_the_leg_that_fails_and_names_it(loop):
    run, drive = loop(), DriveSequence(legs(Goal(6.5, 5.5), Goal(6.5, 7.5)))
    run.run(drive, teleport_at(2.0))
    assert drive.state is State.FAILED
    assert drive.reason.startswith('on the way to corner 2 of 2: something else moved the turtle')


def test_path_ended_from_outside_stays_ended():
    drive = DriveSequence(legs(Goal(6.5, 5.5)))
    drive.end(State.PREEMPTED, 'a newer goal')
    assert drive.step(standing(), DT) == STOP and drive.state is State.PREEMPTED


def test_tolerance_asked_for_is_kept(loop):
    for start, goal in random_drives(10, seed=3):
        run = loop(start)
        drive = GoTo(run.pose, goal, tolerance=Tolerance(position=0.002, heading=0.002))
        run.run(drive)
        assert distance(run.pose, goal) <= 0.002 and heading_error(run.pose, goal) <= 0.002
