"""Tests of navigation_core.planning without ROS: costmaps, paths, velocities."""
import math

import numpy as np
import pytest

from navigation_core.maps.grid_map import GridMap
from navigation_core.planning import global_planner
from navigation_core.planning.costmap import FREE, INSCRIBED, LETHAL, UNKNOWN, Costmap, Inflation, occupancy
from navigation_core.planning.footprint import Footprint
from navigation_core.planning.local_planner import LocalPlanner, Settings, Velocity, along, trajectories
from navigation_core.poses import Pose, wrap

RESOLUTION = 0.1  # [m]
SQUARE = [[0.2, 0.2], [0.2, -0.2], [-0.2, -0.2], [-0.2, 0.2]]


def costmap(rows, unknown='?', inscribed=0.15, radius=0.4):
    """Return the Costmap of a drawing, its first row on top: # is a wall, ? unknown; (0, 0) is its lower left."""
    values = {'#': 100, unknown: -1}
    cells = np.array([[values.get(cell, 0) for cell in row] for row in rows[::-1]])
    return Costmap.of_map(GridMap(cells, RESOLUTION), inscribed, inscribed, Inflation(radius, 5.0))


# ------------------------------------------------------------------------------------------------- footprint

def test_radii_of_footprints():
    square = Footprint.polygon(SQUARE)
    assert (square.inscribed, square.circumscribed) == pytest.approx((0.2, 0.2 * math.sqrt(2.0)))
    assert not square.is_round and Footprint.disc(0.3).is_round
    assert Footprint.polygon(SQUARE, 0.1).inscribed == pytest.approx(0.3)


@pytest.mark.parametrize('corners', [[], [[0, 0]], [[1, 1], [2, 1], [1, 2]], [[1, math.nan], [0, 1], [-1, -1]], 'x'])
def test_footprints_that_are_none_are_refused(corners):
    with pytest.raises(ValueError):
        Footprint.polygon(corners)


# --------------------------------------------------------------------------------------------------- costmap

def test_costs_fall_with_the_distance():
    grid = costmap(['#.......'])
    # 252 exp(-5 (d - 0.15)) at 0.2, 0.3, 0.4 m; nothing beyond the radius of 0.4 m
    expected = [LETHAL, INSCRIBED, 252 * math.exp(-0.25), 252 * math.exp(-0.75), 252 * math.exp(-1.25), 0, 0, 0]
    assert grid.costs[0].tolist() == [int(each) for each in expected]


def test_costs_are_published_as_those_of_costmap_2d():
    assert occupancy(np.array([FREE, 1, 252, INSCRIBED, LETHAL, UNKNOWN])).tolist() == [0, 1, 98, 99, 100, -1]


def test_rays_clear_and_mark_and_windows_give_what_a_full_update_gives():
    grid = costmap(['.' * 30] * 30)
    window = grid.observe((0.55, 0.55), np.array([[2.05, 0.55], [0.55, 1.55]]), np.array([True, False]), 3.0, 2.5)
    grid.update(window)
    assert grid.seen[5, 20] == LETHAL and grid.seen[5, 10] == FREE and grid.seen[15, 5] == FREE
    assert grid.costs[5, 20] == LETHAL and grid.costs[5, 19] == INSCRIBED
    partly = grid.costs.copy()
    grid.update()
    assert (grid.costs == partly).all()
    grid.update(grid.observe((0.55, 0.55), np.array([[2.55, 0.55]]), np.array([True]), 3.0, 2.5))  # it has gone
    assert grid.costs[5, 20] == FREE
    grid.forget_beyond(0.0, 0.0, 0.5)
    assert not (grid.seen == LETHAL).any()


def test_obstacles_keep_their_place_while_the_window_moves():
    grid = Costmap(20, 20, RESOLUTION, inscribed=0.1, track_unknown=False)
    grid.move_to(0.0, 0.0)
    grid.observe((0.0, 0.0), np.array([[0.55, 0.25]]), np.array([True]), 3.0, 2.5)
    for x, y in ((0.3, 0.0), (0.3, -0.4), (-0.2, 0.1)):
        grid.move_to(x, y)
        grid.update()
        column, row = grid.cells(0.55, 0.25)
        assert grid.costs[row, column] == LETHAL
    grid.move_to(9.0, 9.0)
    grid.update()
    assert not (grid.costs == LETHAL).any()


# ------------------------------------------------------------------------------------------------------ paths

ROOM = ['####################',
        '#..................#',
        '#..................#',
        '#..................#',
        '#########..........#',
        '#..................#',
        '#..................#',
        '#..................#',
        '####################']


def test_path_leads_around_a_wall_from_start_to_goal():
    grid = costmap(ROOM)
    plan = global_planner.plan(grid, (0.25, 0.25), (0.35, 0.65))
    assert plan.path[0].tolist() == [0.25, 0.25] and plan.path[-1].tolist() == [0.35, 0.65]
    assert 1.4 < global_planner.length(plan.path) < 2.0  # at least to the wall's end at x = 0.9 and back
    for (x, y), (to_x, to_y) in zip(plan.path, plan.path[1:]):
        parts = np.linspace(0.0, 1.0, 20)
        between = grid.sample(grid.costs, x + parts * (to_x - x), y + parts * (to_y - y), LETHAL)
        assert (between < INSCRIBED).all()


@pytest.mark.parametrize('goal, problem', [
    ((5.0, 0.3), 'the goal (5.00, 0.30) is outside of the map, which has x from 0.00 to 2.00 m and y from 0.00 to '
                 '0.90 m'),
    ((0.45, 0.45), 'the goal (0.45, 0.45) is in an obstacle, or closer to one than the radius of the robot'),
    ((1.85, 0.85), 'the goal (1.85, 0.85) is in an obstacle, or closer to one than the radius of the robot'),
])
def test_goals_without_a_path_are_explained(goal, problem):
    assert global_planner.plan(costmap(ROOM), (0.25, 0.25), goal).problem == problem


def test_closed_room_has_no_path():
    plan = global_planner.plan(costmap(['.....#.....'] * 5), (0.05, 0.25), (1.05, 0.25))
    assert plan.path is None and plan.problem == 'there is no free path from (0.05, 0.25) to (1.05, 0.25)'


def test_a_path_to_where_one_stands_needs_no_search(monkeypatch):
    monkeypatch.setattr(global_planner, 'dijkstra', None)
    assert global_planner.plan(costmap(ROOM), (0.25, 0.25), (0.27, 0.25), 0.3).path.tolist() == [[0.27, 0.25]]


def test_goal_in_a_wall_ends_beside_it_with_a_tolerance():
    plan = global_planner.plan(costmap(ROOM), (0.25, 0.25), (0.45, 0.45), 0.3)
    assert math.dist(plan.path[-1], (0.45, 0.45)) <= 0.3


def test_unknown_cells_are_used_only_if_allowed():
    grid = costmap(['..????..'] * 3)
    assert global_planner.plan(grid, (0.05, 0.15), (0.75, 0.15)).path is not None
    assert global_planner.plan(grid, (0.05, 0.15), (0.75, 0.15), allow_unknown=False).path is None


def test_large_map_costs_what_its_known_part_costs():
    cells = np.full((2000, 2000), -1, np.int8)
    cells[1000:1100, 1000:1100] = 0
    grid = Costmap.of_map(GridMap(cells, 0.05), 0.2, 0.2)
    assert global_planner._part(grid, [(1050, 1050)])[1].size < 150 * 150
    assert global_planner.plan(grid, (50.5, 50.5), (54.5, 54.5)).path is not None


# ------------------------------------------------------------------------------------------------- velocities

def test_trajectories_are_exact_arcs():
    velocities = np.array([[1.0, 0.0, math.pi / 2], [0.0, 1.0, 0.0]])
    quarter = trajectories(velocities, Pose(1.0, 0.0, 0.0), np.array([0.0, 1.0]))
    assert quarter[0, -1] == pytest.approx([1.0 + 2.0 / math.pi, 2.0 / math.pi, math.pi / 2])  # radius 2 / pi
    assert quarter[1, -1] == pytest.approx([1.0, 1.0, 0.0])


def test_distance_from_a_path_and_rest_of_it():
    path = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]])
    beside, rest = along(path, np.array([[0.25, 0.5], [3.0, 1.0], [1.0, 4.0]]))
    assert beside == pytest.approx([0.5, 2.0, 2.0])
    assert rest == pytest.approx([2.75, 1.0, 0.0])


def driven(grid, planner, pose, path, heading, periods=400):
    """Drive exactly as commanded; return the last pose and all velocities."""
    velocity, velocities = Velocity(), []
    planner.start()
    for _ in range(periods):
        choice = planner.choose(grid, pose, velocity, path, heading)
        assert choice.velocity is not None, choice.problem
        velocity = choice.velocity
        velocities.append(velocity)
        pose = Pose(*map(float, trajectories(np.array([velocity]), pose, np.array([planner.period]))[0, 0]))
        if planner.reached:
            break
    return pose, np.array(velocities)


@pytest.mark.parametrize('sideways', [0.0, 0.3])
@pytest.mark.parametrize('heading', [0.0, 2.0, -3.0])
def test_goals_are_reached_within_the_limits(sideways, heading):
    settings = Settings(max_vel_y=sideways, min_vel_y=-sideways, acc_lim_x=1.0, acc_lim_y=1.0, acc_lim_theta=2.0,
                        vy_samples=5, xy_goal_tolerance=0.05, yaw_goal_tolerance=0.05, vx_samples=7)
    grid, planner = costmap(ROOM), LocalPlanner(settings, Footprint.disc(0.15), 0.1)
    path = global_planner.plan(grid, (0.25, 0.25), (0.35, 0.65)).path
    pose, velocities = driven(grid, planner, Pose(0.25, 0.25, 0.0), path, heading)
    assert planner.reached
    assert math.dist(pose[:2], path[-1]) < 0.075 and abs(wrap(pose.yaw - heading)) < 0.05
    assert np.hypot(velocities[:, 0], velocities[:, 1]).max() <= 0.5 + 1e-6
    assert np.abs(velocities[:, 2]).max() <= 1.0 + 1e-6
    changes = np.abs(np.diff(velocities, axis=0)).max(axis=0)
    assert (changes <= np.array([0.1, 0.1, 0.2]) + 1e-6).all()
    if not sideways:
        assert not velocities[:, 1].any()


def test_a_robot_turns_no_further_than_the_tolerance_asks():
    planner = LocalPlanner(Settings(acc_lim_theta=2.0, yaw_goal_tolerance=1.0), Footprint.disc(0.15), 0.1)
    pose, _ = driven(costmap(ROOM), planner, Pose(0.25, 0.25, 0.0), np.array([[0.25, 0.25], [0.26, 0.25]]), 3.0)
    assert planner.reached and 2.0 <= pose.yaw < 2.5


def test_robot_stands_before_an_obstacle_on_its_path():
    grid = costmap(['....................'] * 20)
    grid.seen[:, 10] = LETHAL
    grid.update()
    planner = LocalPlanner(Settings(vx_samples=7), Footprint.disc(0.15), 0.1)
    path, pose, velocity = np.array([[0.2, 1.0], [1.8, 1.0]]), Pose(0.2, 1.0, 0.0), Velocity()
    for _ in range(100):
        choice = planner.choose(grid, pose, velocity, path, 0.0)
        if choice.velocity is None:
            break
        velocity = choice.velocity
        pose = Pose(*map(float, trajectories(np.array([velocity]), pose, np.array([0.1]))[0, 0]))
    assert choice.problem and pose.x < 1.05 - 0.15


def test_square_robot_turns_only_where_its_corners_have_room():
    grid = costmap(['..........'] * 7)
    square = LocalPlanner(Settings(), Footprint.polygon(SQUARE), 0.1)
    grid.seen[0, :] = grid.seen[-1, :] = LETHAL  # 0.5 m between them; the corners need 0.57 m
    grid.update()
    assert square.turn(grid, Pose(0.5, 0.35, 0.0), Velocity(), 1.0).velocity is None
    assert LocalPlanner(Settings(), Footprint.disc(0.15), 0.1).turn(
        grid, Pose(0.5, 0.35, 0.0), Velocity(), 1.0).velocity.theta > 0.0


def test_pushed_robot_brakes():
    planner = LocalPlanner(Settings(), Footprint.disc(0.1), 0.1)
    choice = planner.choose(costmap(['.' * 40] * 40), Pose(1.0, 2.0, 0.0), Velocity(3.0, 0.5, 5.0),
                            np.array([[1.0, 2.0], [3.0, 2.0]]), 0.0)
    assert choice.velocity.x < 3.0
