"""turtle_robotont.markers.tours: markers one after the other, lost ones, missing ones, a tracker that falls silent."""
import math

import pytest

from turtle_robotont.driving.following import Settings
from turtle_robotont.driving.vehicle import STOP, Limits
from turtle_robotont.markers.sightings import Sighting
from turtle_robotont.markers.tours import MAX_TURNS, State, Tour
from unit_support.robot_loop import STEP, Camera, Robot

DISTANCE_TOLERANCE = 0.08  # [m] around 1 m: the tolerance of the goal, and the braking distance
DT = 0.05  # [s]


def go(robot, tour, markers, seconds, see=lambda camera: camera.step()):
    """Let the robot tour until it has ended; return (time [s], state, x, y) of each change."""
    camera, changes = Camera(robot, markers), []
    for number in range(round(seconds / STEP)):
        seen = see(camera)
        if seen is not None:
            tour.see(seen)
        if number % 5 == 0:
            robot.command(tour.step(5 * STEP))
            if not changes or changes[-1][1:3] != (tour.state, tour.marker_id):
                changes.append((robot.time, tour.state, tour.marker_id, robot.x, robot.y))
        robot.step()
    return changes


def test_markers_are_visited_in_order_wherever_they_are():
    robot, tour = Robot((0.0, 0.0, 0.0)), Tour([3, 1, 2])
    places = {1: (-3.0, 1.0), 2: (0.0, -3.0), 3: (2.5, 0.5)}
    go(robot, tour, places, 60.0)
    assert tour.state is State.DONE and tour.finished
    assert [visit.marker_id for visit in tour.reached] == [3, 1, 2]
    assert all(visit.distance == pytest.approx(1.0, abs=DISTANCE_TOLERANCE) for visit in tour.reached)
    assert math.hypot(*robot.seen_from(*places[2])) == pytest.approx(1.0, abs=DISTANCE_TOLERANCE)
    assert tour.status.startswith('visited the markers 3 (')
    assert tour.step(DT) == STOP


def test_marker_that_is_not_there_ends_the_search_and_is_named():
    robot, tour = Robot(), Tour([1, 9], search_speed=1.0)
    go(robot, tour, {1: (2.0, 0.0)}, 30.0)
    assert tour.state is State.FAILED and tour.finished and [visit.marker_id for visit in tour.reached] == [1]
    assert 'marker 9 was not found in 2 turns' in tour.status
    assert robot.theta == pytest.approx(MAX_TURNS * 2.0 * math.pi, abs=0.3)


def test_silent_tracker_stops_the_robot_until_it_speaks():
    tour = Tour([1], Settings(lost_after=0.5))
    assert [tour.step(DT) for _ in range(5)] == [STOP] * 5, 'nothing was heard yet'
    tour.see([])
    said = [tour.step(DT) for _ in range(20)]
    assert said[0].angular_z > 0.0 and said[-1] == STOP and 'publishes nothing' in tour.status
    tour.see([])
    assert tour.step(DT).angular_z > 0.0


def test_marker_that_is_lost_on_the_way_is_searched_where_it_went():
    tour = Tour([1])
    for _ in range(100):
        tour.see([Sighting(1, 3.0, -0.1, 0.0)])
        tour.step(DT)
    assert tour.state is State.APPROACHING
    said = []
    for _ in range(20):
        tour.see([])
        said.append(tour.step(DT))
    assert STOP in said and tour.state is State.SEARCHING
    assert said[-1].angular_z < 0.0, 'it was to the right'


def test_marker_that_is_lost_while_turning_to_it_is_searched_where_it_went():
    tour = Tour([1])
    for _ in range(4):
        tour.see([Sighting(1, 1.0, -1.0, 0.0)])
        tour.step(DT)
    assert tour.state is State.FACING
    said = []
    for _ in range(20):
        tour.see([])
        said.append(tour.step(DT))
    assert STOP in said and tour.state is State.SEARCHING and said[-1].angular_z < 0.0


def test_limits_hold():
    robot, limits = Robot(), Limits(0.2, 0.3)
    tour, commands = Tour([1], Settings(distance=1.0, limits=limits), search_speed=5.0), []
    camera = Camera(robot, {1: (-2.0, 1.0)})
    for _ in range(3000):
        tour.see(camera.step() or [])
        commands.append(tour.step(STEP))
        robot.command(commands[-1])
        robot.step()
    assert max(abs(command.angular_z) for command in commands) <= limits.turn_speed
    assert max(math.hypot(command.linear_x, command.linear_y) for command in commands) <= limits.speed + 1e-9
