"""Whole drives in the simulated minimaze, with scanner and walls, as the bench measures them."""
import math

import pytest

from kinematic_core.worlds.floor_plan import Box
from navigation_core.poses import Pose
from unit_support.goals import SimulatedRobot

pytestmark = pytest.mark.slow


@pytest.mark.parametrize('goal', [Pose(-1.5, 1.5, 2.0), Pose(-2.4, -0.4, -1.0)])
def test_goal_is_reached_close_enough_and_without_a_detour(goal):
    robot = SimulatedRobot(1)
    robot.observe()
    assert robot.drive(goal).good


def test_robot_drives_around_a_box_that_is_not_on_the_map():
    """It stands in the middle between two walls, and is only seen by the scanner."""
    box = Box('box', -2.0, 1.0, 0.0, 0.4, 0.4, 0.5)
    robot = SimulatedRobot(1, unmapped=(box,))
    drive = robot.drive(Pose(-2.0, 2.0, 0.0))
    assert drive.reached and not drive.collisions and drive.distance < 0.1
    assert drive.length > 2.1  # 2 m straight on


def test_robot_that_was_driven_against_a_wall_gets_away_from_it():
    """It stands closer to the wall than the radius that the costmap counts with, and looks along it."""
    robot = SimulatedRobot(1)
    robot.world.place(-2.0, -2.0, 0.0)
    for _ in range(600):
        robot.world.command(0.0, -0.4, 0.0)
        robot.world.step()
    drive = robot.drive(Pose(-1.0, -2.0, 0.0))
    assert drive.reached and not drive.collisions


def test_robot_that_is_carried_away_plans_again():
    robot = SimulatedRobot(1)
    robot.drive(Pose(-1.5, 1.5, 0.0))
    robot.world.place(0.0, -2.0, math.pi)
    drive = robot.drive(Pose(-1.0, -2.0, 0.0))
    assert drive.reached and not drive.collisions
