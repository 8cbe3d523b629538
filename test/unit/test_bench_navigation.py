"""./run bench navigation: when a robot is found, and the log of a carried robot. No node is started."""
import math

import pytest

import suite_navigation
from navigation_core.poses import Pose
from unit_support import maze_drive


@pytest.mark.parametrize('errors, expected', [
    ([1.0] * 10 + [0.1] * 40, 2.0),  # 10 scans of 0.2 s
    ([0.1] * 5 + [1.0] * 5 + [0.1] * 40, 2.0),  # found by chance, lost again
    ([None] * 3 + [0.1] * 40, 0.6), ([1.0] * 50, 10.0)])
def test_a_robot_is_found_once_it_is_not_lost_again(errors, expected):
    assert suite_navigation.until_found(errors) == pytest.approx(expected)


def test_the_wheels_of_a_carried_robot_do_not_turn():
    """Between the two scans around the gap, the odometry stands; after it, each step is that of the drive."""
    log = [maze_drive.Moment(0.2 * index, Pose(0.1 * index, 0.0, 0.0), Pose(0.05 * index, 0.01 * index, 0.02 * index),
                             None) for index in range(suite_navigation.CARRIED[1] + 3)]
    carried, start = suite_navigation.carried_log(log)
    assert (len(carried), start) == (len(log) - 180, 150)  # scans 150 to 329 are left out
    assert carried[start].odometry == pytest.approx(log[start - 1].odometry)
    assert carried[start].truth == log[330].truth
    assert carried[-1].odometry == pytest.approx(carried[-2].odometry.then(log[-2].odometry.step_to(log[-1].odometry)))
    assert [after.time - before.time for before, after in zip(carried, carried[1:])] == pytest.approx(
        [0.2] * (len(carried) - 1))
    assert math.dist(carried[start].truth[:2], carried[start - 1].truth[:2]) > 10.0
