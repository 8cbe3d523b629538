"""move_base.conversions: what is wrong with maps and goals, and scans that measure nothing."""
import math

import numpy as np
import pytest
from geometry_msgs.msg import Point, Pose, Quaternion
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import LaserScan, PointCloud2

from move_base.conversions import goal_problem, grid_of, measures


def message(width=2, height=1, resolution=0.05, cells=(0, 100), x=0.0, z=0.0, w=1.0):
    made = OccupancyGrid(data=list(cells))
    made.info.width, made.info.height, made.info.resolution = width, height, resolution
    made.info.origin.position.x = x
    made.info.origin.orientation.z, made.info.origin.orientation.w = z, w
    return made


def test_a_map():
    grid = grid_of(message(x=-3.0))
    assert grid.cells.tolist() == [[0, 100]] and (grid.resolution, grid.origin.x) == (0.05, -3.0)


@pytest.mark.parametrize('changes, said', [
    ({'width': 20000, 'height': 20000}, 'it has 20000 x 20000 cells; it must have 1 to 25000000'),
    ({'width': 0, 'cells': ()}, 'it has 0 x 1 cells'),
    ({'width': 3}, 'it has 2 values; 3 x 1 cells are stated'),
    ({'resolution': 0.0}, 'its resolution is 0; it must be more than 0 m'),
    ({'resolution': math.nan}, 'its resolution is nan'),
    ({'x': math.nan}, 'all must be finite'),
    ({'w': 0.0}, 'the length of a quaternion must be 1'),
    ({'z': math.sin(0.25), 'w': math.cos(0.25)}, 'its origin is turned by 28.6 degrees; costmaps need 0'),
])
def test_a_map_that_is_refused(changes, said):
    with pytest.raises(ValueError, match=said):
        grid_of(message(**changes))


@pytest.mark.parametrize('ranges, expected', [
    ((1.0, math.nan), True), ((math.inf, math.inf), True), ((math.nan, math.nan), False), ((), False),
    ((0.0, 0.0), False), ((-math.inf,), False), ((9.0,), False),
])
def test_a_scan_that_measures_nothing(ranges, expected):
    assert measures(LaserScan(range_min=0.1, range_max=8.0, ranges=np.array(ranges))) is expected
    assert measures(PointCloud2())


@pytest.mark.parametrize('x, quaternion, said', [
    (1.0, (0.0, 0.0, 0.0, 1.0), ''), (math.nan, (0.0, 0.0, 0.0, 1.0), 'it contains NaN'),
    (1.0, (0.0, 0.0, math.inf, 1.0), 'it contains NaN'), (1.0, (0.0, 0.0, 0.0, 0.0), 'is no orientation'),
    (1.0, (1.0, 0.0, 0.0, 1.0), 'its orientation is not upright')])
def test_a_goal(x, quaternion, said):
    problem = goal_problem(Pose(Point(x, 0.0, 0.0), Quaternion(*quaternion)))
    assert said in problem and bool(said) == bool(problem)
