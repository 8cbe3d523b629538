"""Tests of navigation_core.slam and maps.scores: a drive with a bad odometry, compared with the truth."""
import math

import numpy as np
import pytest

from navigation_core.maps.grid_map import GridMap
from navigation_core.maps.scores import scores
from navigation_core.poses import Pose
from navigation_core.scans import usable
from navigation_core.slam.count_grid import CountGrid
from navigation_core.slam.mapper import Mapper, Settings, drawn
from navigation_core.slam.matching import match, thinned
from unit_support.room import START, WALLS, noisy, scan_at, tour

pytestmark = pytest.mark.slow


def driven(settings, degrees=360, deviation=0.02):
    """Return (Mapper, errors [m] of its pose, end error [m] of the odometry) after a tour."""
    random = np.random.default_rng(5)
    mapper, odometry, last, errors = Mapper(settings, seed=1), START, START, []
    for index, pose in enumerate(tour()):
        odometry = noisy(odometry, last, pose, random, deviation) if index else odometry
        last = pose
        mapper.process(odometry, scan_at(pose, random, degrees), 0.2 * index)
        errors.append(math.hypot(mapper.pose.x - pose.x, mapper.pose.y - pose.y))
    return mapper, errors, math.hypot(odometry.x - last.x, odometry.y - last.y)


@pytest.fixture(scope='module')
def all_around():
    return driven(Settings(area=(-3.0, -3.0, 3.0, 3.0)))


def test_poses_are_right_where_the_odometry_is_not(all_around):
    _, errors, odometry = all_around
    assert odometry > 0.1
    assert np.median(errors) < 0.03 and max(errors) < 0.08  # [m]


def test_the_map_has_all_walls_and_no_others(all_around):
    found = scores(all_around[0].to_map(), WALLS, START[:2])
    assert found.right > 0.99 and found.found > 0.97 and found.iou > 0.95
    assert math.hypot(found.alignment.x, found.alignment.y) < 0.05 and abs(found.alignment.yaw) < 0.02


def test_a_scanner_all_around_needs_one_map(all_around):
    assert all_around[0].entropy() == 0.0
    mapper, errors, _ = driven(Settings(area=(-3.0, -3.0, 3.0, 3.0), particles=5, linear_update=0.3,
                                        angular_update=0.3), degrees=100, deviation=0.005)
    assert 0.0 <= mapper.entropy() <= math.log(5.0)
    assert np.median(errors) < 0.15  # [m]


def test_a_moved_map_is_aligned_and_a_wrong_one_scores_less(all_around):
    grid = all_around[0].to_map()
    moved = GridMap(grid.cells, grid.resolution, Pose(0.3, -0.2, 0.1).then(grid.origin))
    found = scores(moved, WALLS, START[:2])
    assert found.iou > 0.95
    assert tuple(found.alignment) == pytest.approx(tuple(Pose(0.3, -0.2, 0.1).inverse()), abs=0.04)
    half = grid.cells.copy()
    half[:, grid.width // 2:] = -1
    assert scores(GridMap(half, grid.resolution, grid.origin), WALLS, START[:2]).found < 0.7
    stretched = GridMap(grid.cells, 0.06, grid.origin)
    assert scores(stretched, WALLS, START[:2]).right < 0.8


def test_scores_refuse_what_cannot_be_scored(all_around):
    with pytest.raises(ValueError, match='no occupied cell'):
        scores(GridMap.unknown(5, 5, 0.05), WALLS, START[:2])
    with pytest.raises(ValueError, match='not a free place'):
        scores(all_around[0].to_map(), WALLS, (0.5, 0.75))  # in a wall


def test_the_grid_grows_and_ends_at_its_limit():
    grid = CountGrid(0.05, -0.1, -0.1, 0.1, 0.1)
    grid.add(START, scan_at(START))
    found = grid.to_map(0.25)
    assert 80 < found.width < 400 and (found.cells == 100).sum() > 100
    x, y = found.origin[:2]
    assert x <= -2.05 and y <= -1.55
    far = usable(np.full(4, 900.0), 0.0, 0.1, 0.1, 1000.0, 1000.0, Pose())
    grid.add(Pose(), far)
    assert grid.to_map(0.25).width == found.width


def test_a_corridor_leaves_the_expected_pose_along_it():
    """Two walls along x say nothing about x."""
    walls = np.concatenate([np.stack([np.linspace(-3.0, 3.0, 200), np.full(200, side)], axis=1) for side in (-1, 1)])
    angles = np.arctan2(walls[:, 1], walls[:, 0])
    order = np.argsort(angles)
    ranges = np.interp(np.arange(-179, 180), np.degrees(angles[order]), np.hypot(*walls[order].T))
    scan = usable(ranges, math.radians(-179.0), math.radians(1.0), 0.1, 3.0, 3.0, Pose())
    grid = CountGrid(0.05, -4.0, -2.0, 4.0, 2.0)
    grid.add(Pose(), scan)
    found = match(grid, thinned(scan), Pose(0.05, 0.06, 0.03), (0.02, 0.1, 0.1))
    assert found.pose.x == pytest.approx(0.05, abs=0.02)
    assert found.pose.y == pytest.approx(0.0, abs=0.02) and found.pose.yaw == pytest.approx(0.0, abs=0.01)


def test_a_scan_without_a_hit_changes_nothing():
    mapper = Mapper(Settings(area=(-1.0, -1.0, 1.0, 1.0)))
    empty = usable([math.nan, math.inf, 0.0, -1.0, 50.0], 0.0, 0.1, 0.1, 30.0, 30.0, Pose())
    assert not len(empty.points)
    assert not mapper.process(START, empty, 0.0) and mapper.updates == 0
    assert mapper.pose == START  # it is where the odometry begins, seen or not


def test_a_bad_match_leaves_the_pose_to_the_odometry():
    mapper = Mapper(Settings(area=(-3.0, -3.0, 3.0, 3.0), minimum_score=1e6), START)
    mapper.process(START, scan_at(START), 0.0)
    mapper.process(START.then(Pose(0.1, 0.0, 0.0)), scan_at(START), 0.2)
    assert mapper.pose == pytest.approx(START.then(Pose(0.1, 0.0, 0.0)))


@pytest.mark.parametrize('angle_min, increment', [(math.nan, 0.1), (0.0, 0.0), (0.0, 10.0), (0.0, math.inf)])
def test_a_scan_of_impossible_angles_is_refused(angle_min, increment):
    with pytest.raises(ValueError, match='angle_min'):
        usable(np.ones(10), angle_min, increment, 0.1, 30.0, 30.0, Pose())


def test_a_clockwise_scan_is_the_same():
    ranges = np.linspace(1.0, 2.0, 11)
    one = usable(ranges, -0.5, 0.1, 0.1, 30.0, 30.0, Pose())
    other = usable(ranges[::-1], 0.5, -0.1, 0.1, 30.0, 30.0, Pose())
    assert other.points == pytest.approx(one.points)


def test_particles_are_drawn_by_weight():
    assert drawn(np.array([0.5, 0.25, 0.25]), 4, 0.5) == [0, 0, 1, 2]
    assert drawn(np.array([0.0, 1.0]), 3, 0.5) == [1, 1, 1]
