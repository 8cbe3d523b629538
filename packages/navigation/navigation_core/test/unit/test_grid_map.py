"""Tests of navigation_core.maps.grid_map and poses."""
import math

import numpy as np
import pytest

from navigation_core.maps.grid_map import FREE, OCCUPIED, UNKNOWN, GridMap
from navigation_core.poses import Pose, wrap

TURNED = Pose(1.0, 2.0, math.pi / 2)


def test_pose_moves_points_and_back():
    assert TURNED.to_outer(1.0, 0.0) == pytest.approx((1.0, 3.0))  # its x axis points along +y
    assert TURNED.to_inner(1.0, 3.0) == pytest.approx((1.0, 0.0))


def test_poses_are_joined_and_split():
    step = Pose(1.0, 1.0, math.pi / 2)
    assert TURNED.then(step) == pytest.approx((0.0, 3.0, -math.pi))
    assert TURNED.step_to(TURNED.then(step)) == pytest.approx(step)
    assert TURNED.then(TURNED.inverse()) == pytest.approx(Pose())


@pytest.mark.parametrize('angle, wrapped', [
    (0.0, 0.0), (math.pi, -math.pi), (-math.pi, -math.pi), (7.0, 7.0 - 2 * math.pi)])
def test_angles_are_wrapped(angle, wrapped):
    assert wrap(angle) == pytest.approx(wrapped)


def test_cells_and_points_of_a_turned_map():
    """Cell (column 2, row 1) of 0.5 m: its middle is 1.25 m along the map's x and 0.75 m along its y."""
    grid = GridMap.unknown(4, 3, 0.5, TURNED)
    assert grid.to_world(2, 1) == pytest.approx((1.0 - 0.75, 2.0 + 1.25))
    assert grid.to_cell(0.25, 3.25) == (2, 1)
    assert (grid.width, grid.height) == (4, 3)


def test_edges_belong_to_the_upper_cell_and_outside_is_unknown():
    grid = GridMap(np.array([[FREE, OCCUPIED]]), 1.0)
    columns, rows = grid.to_cell(np.array([0.0, 0.999, 1.0, 2.0, -0.001]), np.zeros(5))
    assert columns.tolist() == [0, 0, 1, 2, -1] and rows.tolist() == [0] * 5
    assert grid.contains(columns, rows).tolist() == [True, True, True, False, False]
    assert grid.values(columns, rows).tolist() == [FREE, FREE, OCCUPIED, UNKNOWN, UNKNOWN]


@pytest.mark.parametrize('cells, resolution', [
    (np.zeros(3), 0.05), (np.zeros((0, 4)), 0.05), (np.zeros((2, 2)), 0.0), (np.zeros((2, 2)), math.nan),
    (np.zeros((2, 2)), math.inf), (np.zeros((2, 2)), -1.0)])
def test_impossible_maps_are_refused(cells, resolution):
    with pytest.raises(ValueError, match='shape|resolution'):
        GridMap(cells, resolution)
