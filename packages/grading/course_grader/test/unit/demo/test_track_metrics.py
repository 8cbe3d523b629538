"""course_grader.demo.core.track_metrics: the measurements of tracks with known answers."""
import math

import pytest

from course_grader.demo.core import track_metrics
from kinematic_core.worlds.turtle_world import DT, TurtleWorld
from turtle_robotont.driving.control import Goal
from turtle_robotont.driving.shapes import Point
from turtle_robotont.driving.vehicle import VehicleState

STEP = 0.01  # [m] between two poses of a drawn line


def pose(x, y, theta=0.0, speed=0.0):
    return VehicleState(x, y, theta, speed, 0.0)


def line(*corners):
    """Return a track along the corners, a pose every STEP."""
    track = [pose(*corners[0])]
    for (x0, y0), (x1, y1) in zip(corners, corners[1:]):
        count = round(math.hypot(x1 - x0, y1 - y0) / STEP)
        track += [pose(x0 + (x1 - x0) * i / count, y0 + (y1 - y0) * i / count) for i in range(1, count + 1)]
    return track


def driven(linear, angular, seconds):
    """Return the track of a turtle of the simulated world under a constant command."""
    world, track = TurtleWorld(), []
    for _ in range(round(seconds / DT)):
        world.command('turtle1', linear, 0.0, angular)
        track.append(world.turtles['turtle1'].pose())
        world.step()
    return track


SQUARE = [(2.0, 2.0), (4.0, 2.0), (4.0, 4.0), (2.0, 4.0), (2.0, 2.0)]


@pytest.mark.parametrize('times, rate', [
    ([0.0, 0.1, 0.2, 0.3], 10.0),
    ([0.0, 0.1, 0.9, 1.0, 1.1], 10.0),  # the machine stood still
    ([0.0, 0.2, 0.4], 5.0),
    ([1.0], 0.0),
    ([], 0.0),
])
def test_rate_leaves_out_what_is_late(times, rate):
    assert track_metrics.rate(times) == pytest.approx(rate)


def test_length_of_a_square_is_its_perimeter():
    assert track_metrics.path_length(line(*SQUARE)) == pytest.approx(8.0)


@pytest.mark.parametrize('linear, angular, seconds, turned', [
    (0.5, 0.2, 4.0, 0.8 - 0.2 * DT),  # one step less than there are poses
    (0.5, -0.2, 4.0, 0.2 * DT - 0.8),
    (1.0, 2.0, 8.0, 16.0 - 2.0 * DT),
    (1.0, 0.0, 1.0, 0.0),
])
def test_turning_counts_full_turns_and_curvature_is_turning_by_way(linear, angular, seconds, turned):
    track = driven(linear, angular, seconds)
    assert track_metrics.turned(track) == pytest.approx(turned, abs=1e-6)
    assert track_metrics.curvature(track) == pytest.approx(angular / linear, abs=1e-6)


def test_turtle_that_does_not_move_has_no_curvature():
    assert track_metrics.curvature([pose(1.0, 1.0, theta) for theta in (0.0, 1.0, 2.0)]) == 0.0
    assert track_metrics.curvature([]) == 0.0


def test_jumps_are_found_and_driving_is_none():
    there = pose(9.0, 9.0)
    assert track_metrics.jumps([*line(*SQUARE), there, *line((9.0, 9.0), (9.0, 8.0))]) == [there]
    assert track_metrics.jumps(driven(10.0, 3.0, 2.0)) == []  # 0.16 m a step


def test_top_speed_is_the_highest_reported():
    assert track_metrics.top_speed([pose(0.0, 0.0, 0.0, speed) for speed in (0.0, 1.5, 1.0)]) == 1.5
    assert track_metrics.top_speed([]) == 0.0


@pytest.mark.parametrize('track, rests', [
    ([pose(1.0, 1.0)] * 20, True),
    ([pose(1.0, 1.0)] * 10, False),  # 0.16 s of the 0.2 s asked
    ([*line((1.0, 1.0), (2.0, 1.0)), *[pose(2.0, 1.0)] * 13], True),
    ([*line((1.0, 1.0), (2.0, 1.0)), *[pose(2.0, 1.0)] * 5], False),
    ([pose(1.0, 1.0, 0.01 * i) for i in range(20)], False),  # turns on the spot
    ([], False),
])
def test_rest_is_standing_still_for_long_enough(track, rests):
    assert track_metrics.stands_still(track) is rests


def test_goal_error_takes_the_short_way_round():
    distance, heading = track_metrics.goal_error([pose(1.0, 1.0, -3.1)], Goal(1.3, 1.4, 3.1))
    assert distance == pytest.approx(0.5) and heading == pytest.approx(2.0 * math.pi - 6.2)


def test_closing_error_is_the_gap():
    assert track_metrics.closing_error([]) == math.inf
    assert track_metrics.closing_error(line(*SQUARE)) == 0.0
    assert track_metrics.closing_error(line((1.0, 1.0), (4.0, 5.0))) == 5.0


@pytest.mark.parametrize('corners, deviation', [
    (SQUARE, 0.0),
    ([(2.0, 2.0), (4.0, 2.3), (4.0, 4.0), (2.0, 4.0), (2.0, 2.0)], 0.29),  # below the slanted side, near its end
    ([(2.0, 2.0), (2.0, 2.0), (4.0, 2.0)], 2.0),  # the far side of the square; a line without length
])
def test_path_deviation_is_the_largest_distance_from_the_lines(corners, deviation):
    track = line(*SQUARE)
    path = [Point(*corner) for corner in corners]
    assert track_metrics.path_deviation(track, path) == pytest.approx(deviation, abs=0.02)
