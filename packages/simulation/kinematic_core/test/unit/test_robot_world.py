"""kinematic_core.worlds.robot_world: commands, watchdog, walls, odometry, determinism."""
import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinematic_core.worlds.floor_plan import Box, FloorPlan, Panel
from kinematic_core.worlds.omni import Limits
from kinematic_core.worlds.planar import STILL, Pose2D, Twist2D, advance
from kinematic_core.worlds.robot_world import DT, WATCHDOG, RobotWorld
from plain_support import InvalidInput

pytestmark = pytest.mark.slow

LENGTH_TOLERANCE = 1e-6  # [m, rad]
WALL = Box('wall', 1.0, 0.0, 0.0, 0.1, 20.0, 0.5)  # the robot stops at x = 0.95 - 0.18 = 0.77
ROOM = FloorPlan(boxes=(Box('east', 1.1, 0.0, 0.0, 0.2, 2.4, 0.5), Box('west', -1.1, 0.0, 0.0, 0.2, 2.4, 0.5),
                        Box('north', 0.0, 1.1, 0.0, 2.0, 0.2, 0.5), Box('south', 0.0, -1.1, 0.0, 2.0, 0.2, 0.5)))
INSIDE_ROOM = 1.0 - 0.18 + LENGTH_TOLERANCE  # [m] from the middle


def drive(world, steps, *command):
    """Command in every step; return the world."""
    for _ in range(steps):
        world.command(*command)
        world.step()
    return world


def test_step_fits_the_rates_of_the_topics():
    for rate in (30.0, 40.0):
        assert (1.0 / rate / DT) == pytest.approx(round(1.0 / rate / DT))


def test_it_drives_the_exact_arc():
    world = drive(RobotWorld(), 120, 0.5, -0.2, 0.7)
    assert world.pose == pytest.approx(advance(Pose2D(), Twist2D(0.5, -0.2, 0.7), 1.0), abs=LENGTH_TOLERANCE)
    assert world.time == pytest.approx(1.0)
    assert world.twist == Twist2D(0.5, -0.2, 0.7)
    assert world.odometry.pose == world.pose


def test_command_takes_effect_in_the_next_step_and_the_last_one_counts():
    world = RobotWorld()
    world.command(1.0, 0.0, 0.0)
    world.command(0.0, 2.0, 0.0)
    assert world.pose == Pose2D() and world.twist == STILL
    world.step()
    assert world.pose[:2] == pytest.approx((0.0, 2.0 * DT))


def test_watchdog_stops_after_half_a_second():
    world = RobotWorld()
    world.command(1.0, 0.0, 1.0)
    for _ in range(60):
        world.step()
    assert world.twist == Twist2D(1.0, 0.0, 1.0) and not world.timed_out
    world.step()
    assert world.twist == STILL and world.timed_out
    stopped = world.pose
    world.step()
    assert world.pose == stopped and world.timed_out
    assert stopped.yaw == pytest.approx(WATCHDOG)  # 60 steps at 1 rad/s
    world.command(1.0, 0.0, 0.0)
    assert not world.timed_out


def test_watchdog_has_nothing_to_say_when_the_robot_stands_anyway():
    world = drive(RobotWorld(), 1, 0.0, 0.0, 0.0)
    for _ in range(100):
        world.step()
    assert not world.timed_out


def test_watchdog_can_be_longer_or_never():
    world, endless = RobotWorld(watchdog=1.0), RobotWorld(watchdog=math.inf)
    for each in (world, endless):
        each.command(1.0, 0.0, 0.0)
        for _ in range(600):
            each.step()
    assert world.pose.x == pytest.approx(1.0)
    assert endless.pose.x == pytest.approx(5.0)


def test_watchdog_brakes_within_the_limits():
    world = drive(RobotWorld(limits=Limits(acceleration=1.0)), 120, 0.5, 0.0, 0.0)
    speeds = []
    for _ in range(180):
        world.step()
        speeds.append(world.twist.linear_x)
    # 0.5 s of the watchdog, less the step of the last command, then 0.5 s at 1 m/s^2
    assert [round(speed, 6) for speed in speeds[:59]] == [0.5] * 59
    assert speeds[58 + 30] == pytest.approx(0.25)
    assert speeds[58 + 60:] == pytest.approx([0.0] * len(speeds[58 + 60:]))


def test_it_accelerates_within_the_limits():
    world = drive(RobotWorld(limits=Limits(speed=0.4, acceleration=0.5)), 120, 3.0, 0.0, 0.0)
    # 0.4 m/s after 0.8 s: 0.16 m, then 0.2 s: 0.08 m; steps of constant speed are half a step ahead: 0.4 * DT / 2
    assert world.twist == Twist2D(0.4, 0.0, 0.0)
    assert world.pose.x == pytest.approx(0.24 + 0.4 * DT / 2.0, abs=1e-4)


def test_it_stops_at_a_wall_and_says_so():
    world = drive(RobotWorld(FloorPlan(boxes=(WALL,))), 240, 1.0, 0.0, 0.0)
    assert world.pose == pytest.approx((0.77, 0.0, 0.0), abs=LENGTH_TOLERANCE)
    assert world.twist == pytest.approx(STILL, abs=LENGTH_TOLERANCE)
    assert world.touching
    drive(world, 1, -1.0, 0.0, 0.0)
    assert not world.touching and world.twist.linear_x == pytest.approx(-1.0)


def test_it_slides_along_a_wall_with_what_is_left_of_its_speed():
    world = drive(RobotWorld(FloorPlan(boxes=(WALL,)), start=Pose2D(0.7, 0.0, math.pi / 6.0)), 120, 1.0, 0.0, 0.0)
    # cos 30 into the wall is lost, sin 30 along it stays; seen from the robot that is sin 30 * (sin 30, cos 30)
    assert world.pose.x == pytest.approx(0.77, abs=LENGTH_TOLERANCE)
    assert world.pose.y == pytest.approx(0.5, abs=LENGTH_TOLERANCE)
    assert world.twist == pytest.approx((0.25, 0.5 * math.sqrt(0.75), 0.0), abs=LENGTH_TOLERANCE)
    assert world.odometry.pose == world.pose


def test_it_turns_at_a_wall_as_elsewhere():
    world = drive(RobotWorld(FloorPlan(boxes=(WALL,)), start=Pose2D(0.77, 0.0, 0.0)), 120, 0.0, 0.0, 1.5)
    assert world.pose == pytest.approx((0.77, 0.0, 1.5), abs=LENGTH_TOLERANCE)


@given(seed=st.integers(0, 2 ** 32), dt=st.sampled_from([DT, 0.1, 1.0, 7.0]),
       top=st.sampled_from([0.5, 5.0, 9.9]), limits=st.sampled_from([Limits(), Limits(acceleration=3.0)]))
def test_it_never_leaves_a_closed_room(seed, dt, top, limits):
    dice = random.Random(seed)
    world = RobotWorld(ROOM, dt=dt, limits=limits, watchdog=math.inf)
    for _ in range(40):
        world.command(dice.uniform(-0.7, 0.7) * top, dice.uniform(-0.7, 0.7) * top, dice.uniform(-40.0, 40.0))
        world.step()
        assert max(abs(world.pose.x), abs(world.pose.y)) <= INSIDE_ROOM
        assert all(math.isfinite(value) for value in (*world.pose, *world.twist, *world.odometry.pose))


@given(x=st.floats(-3.0, 3.0), y=st.floats(-3.0, 3.0), turn=st.floats(-10.0, 10.0))
def test_odometry_follows_the_true_twist_at_walls(x, y, turn):
    # rolled instead of copied: the measured wheels lead to the pose of the robot
    world = RobotWorld(ROOM, start=Pose2D(0.5, 0.5, 0.3))
    world.odometry.exact = False
    drive(world, 120, x, y, turn)
    assert world.odometry.pose[:2] == pytest.approx(world.pose[:2], abs=1e-6)


def test_wheels_turn_as_the_robot_moves():
    world = drive(RobotWorld(), 120, 0.0, 0.0, 1.0)
    assert world.wheel_angles == pytest.approx([0.146 / 0.035] * 3)
    assert world.wheel_speeds == pytest.approx([0.146 / 0.035] * 3)
    world = drive(RobotWorld(FloorPlan(boxes=(WALL,)), start=Pose2D(0.77, 0.0, 0.0)), 120, 1.0, 0.0, 0.0)
    assert world.wheel_angles == pytest.approx([0.0] * 3, abs=1e-4)  # they stall at the wall


@pytest.mark.parametrize('command, said', [
    ((math.nan, 0.0, 0.0), 'linear.x is nan'),
    ((0.0, math.inf, 0.0), 'linear.y is inf'),
    ((0.0, 0.0, -math.inf), 'angular.z is -inf'),
    ((8.0, 8.0, 0.0), 'linear is 11.3137 m/s; it must be at most 10'),
    ((1e9, 0.0, 0.0), r'linear is 1e\+09 m/s; it must be at most 10'),
    ((0.0, 0.0, 50.1), 'angular.z is 50.1 rad/s; it must be -50 to 50'),
    ((1e300, 1e300, 0.0), r'linear is 1.41421e\+300 m/s; it must be at most 10'),
])
def test_absurd_command_stops_the_robot(command, said):
    world = drive(RobotWorld(), 10, 1.0, 0.0, 0.0)
    before = world.pose
    with pytest.raises(InvalidInput, match=said):
        world.command(*command)
    world.step()
    assert world.twist == STILL and world.pose == before and not world.timed_out
    drive(world, 1, 1.0, 0.0, 0.0)
    assert world.twist.linear_x == 1.0


def test_spawn_inside_a_wall_is_refused():
    with pytest.raises(InvalidInput, match=r'the robot cannot be at x=1, y=0: wall is closer than the radius of'):
        RobotWorld(FloorPlan(boxes=(WALL,)), start=Pose2D(1.0, 0.0, 0.0))


def test_placing_stops_the_robot_and_begins_its_odometry_there():
    world = drive(RobotWorld(FloorPlan(boxes=(WALL,)), slip=0.2), 60, 1.0, 0.0, 0.5)
    world.place(-2.0, 1.0, 4.0)
    assert world.pose == world.odometry.pose == pytest.approx((-2.0, 1.0, 4.0 - 2.0 * math.pi))
    world.step()
    assert world.twist == STILL and world.pose.x == -2.0
    assert world.wheel_angles == pytest.approx([0.0] * 3) and world.odometry.distance == 0.0


@pytest.mark.parametrize('place', [(0.9, 0.0, 0.0), (math.nan, 0.0, 0.0), (0.0, 0.0, math.inf), (0.0, 1e9, 0.0)])
def test_place_that_cannot_be_changes_nothing(place):
    world = drive(RobotWorld(FloorPlan(boxes=(WALL,))), 10, 0.5, 0.0, 0.0)
    before = world.pose
    with pytest.raises(InvalidInput):
        world.place(*place)
    world.step()
    assert world.pose.x == pytest.approx(before.x + 0.5 * DT)  # and it drives on


PANELS = FloorPlan(boxes=(WALL,), panels=(Panel('marker1', 1, -1.0, 0.0, math.pi),))


def test_moved_panel_is_where_it_was_moved_to():
    world = RobotWorld(PANELS)
    world.move_panel('marker1', 0.5, 0.0, 0.0)
    assert world.plan.panels[0].x == 0.5
    drive(world, 120, 1.0, 0.0, 0.0)
    assert world.pose.x == pytest.approx(0.32, abs=LENGTH_TOLERANCE)  # 0.5 - 0.18


@pytest.mark.parametrize('arguments, said', [
    (('marker1', 0.1, 0.0, 0.0), "the panel 'marker1' cannot be at x=0.1, y=0: the robot is there"),
    (('marker2', 1.0, 0.0, 0.0), 'the panels are: marker1'),
    (('marker1', math.nan, 0.0, 0.0), 'x is nan'),
])
def test_panel_that_cannot_be_moved_stays(arguments, said):
    world = RobotWorld(PANELS)
    with pytest.raises(InvalidInput, match=said):
        world.move_panel(*arguments)
    assert world.plan == PANELS
    drive(world, 120, 0.5, 0.0, 0.0)
    assert world.pose.x == pytest.approx(0.5)


def trace(seed):
    world = RobotWorld(ROOM, slip=0.05, noise=0.02, seed=seed)
    dice, poses = random.Random(5), []
    for _ in range(300):
        world.command(dice.uniform(-2.0, 2.0), dice.uniform(-2.0, 2.0), dice.uniform(-3.0, 3.0))
        world.step()
        poses.append((world.pose, world.odometry.pose, world.wheel_angles))
    return repr(poses)


def test_same_seed_and_commands_give_the_same_bits():
    assert trace(1) == trace(1)
    assert trace(1) != trace(2)


def test_odometry_drifts_from_the_true_pose_with_slip():
    world = drive(RobotWorld(slip=0.1), 120, 0.9, 0.0, 0.0)
    assert world.pose.x == pytest.approx(0.9)
    assert world.odometry.pose.x == pytest.approx(1.0)


def test_wheels_of_a_robot_that_is_carried_do_not_turn():
    """The noisy odometry stays where it was; the exact one is the true pose by definition."""
    for noise, believed in ((0.01, Pose2D(1.0, 0.0, 0.0)), (0.0, Pose2D(3.0, 4.0, 0.5))):
        world = RobotWorld(start=Pose2D(1.0, 0.0, 0.0), noise=noise)
        world.carry(3.0, 4.0, 0.5)
        assert (world.pose, world.odometry.pose) == (Pose2D(3.0, 4.0, 0.5), believed)
