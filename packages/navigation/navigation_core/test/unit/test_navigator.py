"""Tests of navigation_core.planning.navigator: what is planned, followed and tried when."""
import math

import numpy as np
import pytest

from navigation_core.planning.global_planner import Plan
from navigation_core.planning.local_planner import Choice, Velocity
from navigation_core.planning.navigator import Navigator, Patience, State
from navigation_core.poses import Pose

PERIOD = 0.1  # [s]
PATH = Plan(np.stack([np.linspace(0.0, 2.0, 41), np.zeros(41)], axis=1))
NONE = Plan(None, 'no path')
FORWARD = Choice(Velocity(0.5, 0.0, 0.0))
STUCK = Choice(None, problem='blocked')


class Robot:
    """A World whose answers a test sets; it moves as it is told."""

    def __init__(self):
        self.pose, self.answer, self.choice, self.hopeless = Pose(), PATH, FORWARD, False
        self.plans, self.cleared, self.turned = 0, [], 0.0

    def plan(self, goal):
        self.plans += 1
        return self.answer

    def is_hopeless(self, goal):
        return self.hopeless

    def follow(self, path, heading, new):
        return self.choice, self.pose.x >= 2.0

    def turn(self, angle):
        return Choice(Velocity(0.0, 0.0, 1.0))

    def clear(self, distance):
        self.cleared.append(distance)

    def run(self, navigator, seconds):
        """Do ``seconds`` of periods, or until the goal is reached or given up; return the time it took."""
        for period in range(round(seconds / PERIOD)):
            velocity = navigator.step(self.pose, period * PERIOD).velocity
            self.turned += velocity.theta * PERIOD
            yaw = math.remainder(self.pose.yaw + velocity.theta * PERIOD, math.tau)
            self.pose = Pose(self.pose.x + velocity.x * PERIOD, self.pose.y, yaw)
            if navigator.state in (State.REACHED, State.FAILED):
                break
        return period * PERIOD


def started(robot, **patience):
    navigator = Navigator(robot, Patience(**patience))
    navigator.start(Pose(2.0, 0.0, 0.0), robot.pose, 0.0)
    return navigator


def test_goal_is_reached_with_one_plan():
    robot = Robot()
    navigator = started(robot)
    assert robot.run(navigator, 10.0) == pytest.approx(4.1, abs=0.15)  # 2 m at 0.5 m/s, and a period to plan
    assert navigator.state == State.REACHED and robot.plans == 1


def test_planner_frequency():
    robot = Robot()
    robot.run(started(robot, planner_frequency=2.0), 10.0)
    assert 7 <= robot.plans <= 9  # 4 s


def test_goal_without_a_path_is_given_up_after_all_recoveries():
    robot = Robot()
    robot.answer = NONE
    navigator = started(robot, planner_patience=1.0)
    took = robot.run(navigator, 100.0)
    assert navigator.state == State.FAILED and navigator.problem == 'no path'
    assert robot.cleared == [3.0, 0.5]
    assert robot.turned == pytest.approx(2.0 * math.tau, abs=0.5)
    assert took == pytest.approx(5.0 + 2.0 * math.tau, abs=2.0)  # five times patience, two turns at 1 rad/s


@pytest.mark.parametrize('patience, cleared, turned', [
    ({'recovery_behavior_enabled': False}, [], 0.0), ({'clearing_rotation_allowed': False}, [3.0, 0.5], 0.0)])
def test_recoveries_can_be_switched_off(patience, cleared, turned):
    robot = Robot()
    robot.answer = NONE
    navigator = started(robot, planner_patience=1.0, **patience)
    robot.run(navigator, 100.0)
    assert navigator.state == State.FAILED and (robot.cleared, robot.turned) == (cleared, turned)


def test_hopeless_goal_is_given_up_at_once():
    robot = Robot()
    robot.answer, robot.hopeless = NONE, True
    navigator = started(robot)
    assert robot.run(navigator, 10.0) == 0.0 and navigator.state == State.FAILED


def test_blocked_robot_plans_again_and_goes_on():
    robot = Robot()
    robot.choice = STUCK
    navigator = started(robot)
    robot.run(navigator, 2.0)
    assert robot.plans > 5 and robot.pose == Pose()
    robot.choice = FORWARD
    robot.run(navigator, 10.0)
    assert navigator.state == State.REACHED and not robot.cleared


def test_robot_that_is_pushed_off_its_path_plans_again():
    robot = Robot()
    navigator = started(robot)
    robot.run(navigator, 1.0)
    robot.pose = Pose(0.5, 1.0, 0.0)
    navigator.step(robot.pose, 1.0)
    assert robot.plans == 2


def test_robot_that_is_told_to_drive_but_does_not_move_recovers():
    robot = Robot()
    robot.choice = Choice(Velocity(0.0, 0.01, 0.0))  # run() ignores y
    navigator = started(robot, controller_patience=2.0, clearing_rotation_allowed=False)
    took = robot.run(navigator, 30.0)
    assert navigator.state == State.FAILED and 6.0 <= took <= 7.0  # three times patience
    assert navigator.problem == 'the robot has not moved for 2 s'


def test_oscillation_timeout():
    robot = Robot()
    robot.choice = Choice(Velocity(0.0, 0.0, 0.5))
    navigator = started(robot, oscillation_timeout=1.0, recovery_behavior_enabled=False)
    assert robot.run(navigator, 30.0) == pytest.approx(1.1, abs=0.15)
    assert navigator.problem == 'the robot has not moved 0.5 m from where it was'
