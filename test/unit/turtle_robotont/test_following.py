"""turtle_robotont.driving.following: velocities, limits, a lost marker, and the closed loop."""
import math

import pytest

from kinematic_core.worlds.planar import Twist2D
from turtle_robotont.driving import following
from turtle_robotont.driving.following import Follower, Settings, State
from turtle_robotont.driving.vehicle import STOP, Limits
from turtle_robotont.markers.sightings import Sighting
from unit_support.robot_loop import STEP, Camera, Robot

DISTANCE_TOLERANCE = 0.02  # [m]
BEARING_TOLERANCE = 0.02  # [rad]
ROUNDING = 1e-9
DT = 0.1  # [s]


def settled(ahead, left, **settings):
    """Return the command of a Follower that has seen marker 1 there for long."""
    follower = Follower(1, Settings(limits=Limits(10.0, 10.0), **settings))
    for _ in range(100):
        follower.see([Sighting(1, ahead, left, 0.0)])
        command = follower.step(DT)
    return command


@pytest.mark.parametrize('ahead, left, settings, command', [
    (1.0, 0.0, {}, Twist2D(linear_x=0.6)),  # 1.2 /s * (1.0 - 0.5) m
    (0.3, 0.0, {}, Twist2D(linear_x=-0.24)),  # too near: back
    (1.5, 0.0, {'distance': 1.5}, STOP),
    (0.505, 0.0, {}, STOP),  # 5 mm lie in the dead band
    (0.0, 1.0, {}, Twist2D(angular_z=1.5 * math.pi / 2.0)),  # to the left: only turn
    (0.3, -0.4, {}, Twist2D(angular_z=1.5 * math.atan2(-0.4, 0.3))),  # at 0.5 m already
    (1.0, 0.5, {'strafe': True}, Twist2D(linear_x=0.6, linear_y=0.6)),
    (0.5, -1.0, {'strafe': True}, Twist2D(linear_y=-1.2)),
])
def test_wanted_velocity(ahead, left, settings, command):
    assert settled(ahead, left, **settings) == pytest.approx(command, abs=ROUNDING)


@pytest.mark.parametrize('strafe', [False, True])
def test_limits_hold_whatever_is_seen_and_come_last(strafe):
    limits = Limits(0.3, 0.4)
    follower = Follower(1, Settings(strafe=strafe, limits=limits))
    before = STOP
    for ahead, left in [(90.0, -90.0), (-90.0, 1e-9), (0.0, 0.0), (1e-300, 90.0)] * 20:
        follower.see([Sighting(1, ahead, left, 0.0)])
        command = follower.step(DT)
        assert all(map(math.isfinite, command))
        assert math.hypot(command.linear_x, command.linear_y) <= limits.speed + ROUNDING
        assert abs(command.angular_z) <= limits.turn_speed + ROUNDING
        change = math.hypot(command.linear_x - before.linear_x, command.linear_y - before.linear_y)
        assert change <= following.ACCELERATION * DT + ROUNDING
        before = command


def test_nothing_is_said_before_the_marker_was_seen():
    follower = Follower(1)
    follower.see([])
    follower.see([Sighting(2, 1.0, 0.0, 0.0)])
    assert follower.step(DT) is None and follower.state is State.WAITING
    assert follower.status == 'waiting for marker 1'


@pytest.mark.parametrize('heard, advised', [(True, True), (False, False)])  # a silent tracker is another problem
def test_a_marker_that_stays_out_of_view_has_to_be_searched_for_and_that_is_said(heard, advised):
    follower, said = Follower(1), []
    for _ in range(int(2.0 * following.ADVISE_AFTER / DT)):
        if heard:
            follower.see([])
        assert follower.step(DT) is None
        said.append(follower.status)
    assert set(said[:round(following.ADVISE_AFTER / DT)]) == {'waiting for marker 1'}
    assert ('turn the robot' in said[-1] and 'ar_maze.py' in said[-1]) is advised


@pytest.mark.parametrize('others, why', [([Sighting(2, 1.0, 0.0, 0.0)], 'not in view'), ([], 'not in view'),
                                         (None, 'the tracker publishes nothing')])
def test_lost_marker_stops_the_robot_once(others, why):
    follower = Follower(1, Settings(lost_after=0.5))
    said = []
    for number in range(20):
        if number < 5:
            follower.see([Sighting(1, 2.0, 0.0, 0.0)])
        elif others is not None:
            follower.see(others)
        said.append(follower.step(DT))
    # seen last before step 4, from which the time counts: lost in the step that makes it more than 0.5 s
    lost = said.index(STOP)
    assert lost in (9, 10) and all(command.linear_x > 0.0 for command in said[:lost])
    assert said[lost + 1:] == [None] * (19 - lost)
    assert follower.state is State.LOST and why in follower.status


def test_a_loop_that_is_slower_than_lost_after_follows_a_marker_that_it_has_just_seen():
    follower = Follower(1, Settings(lost_after=0.3))
    for _ in range(3):
        follower.see([Sighting(1, 2.0, 0.0, 0.0)])
        assert follower.step(1.0).linear_x == pytest.approx(0.5) and follower.status.startswith('following')
    assert follower.step(1.0) == STOP and follower.step(1.0) is None


def test_nearest_of_two_with_one_id_is_followed():
    follower = Follower(1)
    near = Sighting(1, 1.0, 0.2, 0.0)
    follower.see([Sighting(1, 3.0, 0.0, 0.0), near, Sighting(2, 0.5, 0.0, 0.0), Sighting(1, 1.5, -1.0, 0.0)])
    assert follower.sighting == near


def test_marker_that_comes_back_is_followed_from_standing():
    follower = Follower(1)
    follower.see([Sighting(1, 2.0, 0.0, 0.0)])
    for _ in range(10):
        follower.step(DT)
    assert follower.state is State.LOST
    follower.see([Sighting(1, 2.0, 0.0, 0.0)])
    assert follower.step(DT).linear_x == pytest.approx(following.ACCELERATION * DT)
    assert follower.state is State.FOLLOWING


def follow_for(seconds, robot, follower, place):
    """Let the robot follow marker 1, which is at ``place(time)``; return the distances on the way."""
    camera, distances = Camera(robot, {}), []
    for number in range(round(seconds / STEP)):
        camera.markers = {1: place(robot.time)}
        seen = camera.step()
        if seen is not None:
            follower.see(seen)
        if number % 10 == 0:
            robot.command(follower.step(10 * STEP) or STOP)
        robot.step()
        distances.append(math.hypot(*robot.seen_from(*place(robot.time))))
    return distances


@pytest.mark.parametrize('start', [(0.0, 0.0, 0.0), (1.7, 0.1, -0.2), (-1.0, 1.0, -0.5)])
def test_robot_comes_to_its_distance_and_faces_the_marker(start):
    robot, follower = Robot(start), Follower(1, Settings(distance=0.5))
    distances = follow_for(20.0, robot, follower, lambda time: (2.0, 0.0))
    assert distances[-1] == pytest.approx(0.5, abs=DISTANCE_TOLERANCE)
    assert min(distances) > min(0.5, distances[0]) - DISTANCE_TOLERANCE, 'it went too near'
    ahead, left = robot.seen_from(2.0, 0.0)
    assert math.atan2(left, ahead) == pytest.approx(0.0, abs=BEARING_TOLERANCE)


def test_strafing_robot_keeps_its_heading():
    robot, follower = Robot((0.0, 0.0, 0.0)), Follower(1, Settings(distance=0.5, strafe=True))
    follow_for(15.0, robot, follower, lambda time: (1.5, 0.6))
    assert robot.seen_from(1.5, 0.6) == pytest.approx((0.5, 0.0), abs=DISTANCE_TOLERANCE)
    assert robot.theta == 0.0


def test_leader_is_followed_round_a_bend():
    """A leader at 0.25 m/s on a circle of 1.5 m: it is never lost, never touched, and stays near."""
    robot, follower = Robot((0.0, 0.0, 0.0)), Follower(1, Settings(distance=0.6))
    distances = follow_for(30.0, robot, follower,
                           lambda time: (0.6 + 1.5 * math.sin(time / 6.0), 1.5 - 1.5 * math.cos(time / 6.0)))
    assert follower.state is State.FOLLOWING
    assert 0.5 < min(distances) and max(distances) < 1.0
