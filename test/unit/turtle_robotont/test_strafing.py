"""Shapes by a robot on ideal odometry, turning and strafing: corners, sides, heading and speeds."""
import math

import pytest

from kinematic_core.worlds.angles import wrap_angle
from kinematic_core.worlds.planar import Twist2D
from turtle_robotont.driving import drawing
from turtle_robotont.driving.control import Goal, State
from turtle_robotont.driving.strafing import StrafeTo, body_velocity
from turtle_robotont.driving.vehicle import ROBOT, STOP, Limits
from unit_support.robot_loop import Robot, drive, path_deviation

CORNER_TOLERANCE = 0.02  # [m] limit for a robot with ideal odometry
HEADING_TOLERANCE = 0.03  # [rad]
DELAYS = (0, 5, 10)  # steps of 10 ms
ROUNDING = 1e-9


@pytest.mark.parametrize('speed, direction, theta, command', [
    (0.5, 0.0, 0.0, Twist2D(0.5, 0.0, 0.1)),
    (0.5, math.pi / 2.0, 0.0, Twist2D(0.0, 0.5, 0.1)),  # to the left
    (0.5, math.pi / 2.0, math.pi / 2.0, Twist2D(0.5, 0.0, 0.1)),  # where it looks
    (0.5, 0.0, math.pi / 2.0, Twist2D(0.0, -0.5, 0.1)),  # looking left, to the right
])
def test_body_velocity_is_the_direction_seen_from_the_vehicle(speed, direction, theta, command):
    assert body_velocity(speed, direction, theta, 0.1) == pytest.approx(command, abs=ROUNDING)


@pytest.mark.parametrize('delay', DELAYS)
@pytest.mark.parametrize('strafe', [False, True], ids=['turning', 'strafing'])
@pytest.mark.parametrize('shape, size, start, limits', [
    ('square', 0.5, (-2.0, 0.0, 0.0), ROBOT.limits),
    ('square', 2.0, (30.0, -40.0, 2.5), ROBOT.limits),  # far outside the turtles' arena
    ('triangle', 1.0, (0.0, 0.0, -1.0), Limits(0.3, 1.0)),
    ('circle', 1.0, (0.0, 0.0, 3.0), ROBOT.limits),
    ('circle', 0.5, (1.0, 2.0, 0.0), ROBOT.limits),
    ('corners', None, (0.0, 0.0, 0.5), Limits(1.0, 2.0)),
])
def test_robot_draws_within_2_cm(shape, size, start, limits, strafe, delay):
    robot = Robot(start, delay)
    corners = [[0.5, 0.0], [0.5, 0.8], [-0.3, 0.8]]
    plan = drawing.plan(shape, robot.pose, size, corners, limits, ROBOT, strafe)
    track, commands = drive(robot, plan.drive)
    assert plan.drive.state is State.ARRIVED, plan.drive.reason
    worst, gap = plan.errors(track)
    assert worst <= CORNER_TOLERANCE and gap <= CORNER_TOLERANCE
    if plan.corners:
        assert path_deviation(track, [track[0], *plan.corners]) <= CORNER_TOLERANCE
    assert max(math.hypot(command.linear_x, command.linear_y) for command in commands) <= limits.speed + ROUNDING
    assert max(abs(command.angular_z) for command in commands) <= limits.turn_speed + ROUNDING
    turned = max(abs(wrap_angle(pose.theta - start[2])) for pose in track)
    assert turned < HEADING_TOLERANCE if strafe else turned > math.pi / 2.0
    assert any(command.linear_y for command in commands) is strafe


def test_robot_that_was_pushed_off_its_side_comes_back_to_it():
    robot = Robot()
    side = StrafeTo(robot.pose, Goal(2.0, 0.0), 0.0)

    def push(robot):
        if robot.time == pytest.approx(1.5):
            robot.y += 0.1
    track, _ = drive(robot, side, push)
    pushed = next(pose.x for pose in track if pose.y > 0.09)
    assert side.state is State.ARRIVED
    assert max(abs(pose.y) for pose in track if pose.x > pushed + 0.5) < 0.01


def test_strafing_turns_back_to_its_heading():
    robot = Robot((0.0, 0.0, 0.3))
    side = StrafeTo(robot.pose, Goal(0.0, 1.0), 0.0)
    drive(robot, side)
    assert side.state is State.ARRIVED
    assert (robot.x, robot.y, robot.theta) == pytest.approx((0.0, 1.0, 0.0), abs=CORNER_TOLERANCE)


@pytest.mark.parametrize('strafe', [False, True])
@pytest.mark.parametrize('shape', ['square', 'circle'])
def test_shape_planned_from_a_pose_that_was_not_the_robots_is_not_begun(shape, strafe):
    """Two nodes publish odometry: planned from the one, driven by the other."""
    plan = drawing.plan(shape, Robot((50.0, 0.0, 0.0)).pose, 0.5, vehicle=ROBOT, strafe=strafe)
    track, commands = drive(Robot(), plan.drive)
    assert plan.drive.state is State.FAILED
    assert 'moved the robot from (50.00, 0.00) to (0.00, 0.00)' in plan.drive.reason
    assert set(commands) == {STOP}


def test_stuck_robot_is_named():
    side, pose = StrafeTo(Goal(0.0, 0.0), Goal(1.0, 0.0), 0.0), Robot().pose
    for _ in range(100):
        command = side.step(pose, 0.033)
    assert side.state is State.FAILED and command == STOP
    assert 'the robot has not moved for 2 s' in side.reason
