"""Messages to move_base that are wrong: refused with what is wrong, or the robot stands."""
import math
from types import SimpleNamespace

import numpy as np
import pytest
import rospy
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import LaserScan, PointCloud2

from move_base import costmaps
from move_base.conversions import grid_of, measures


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


def test_a_sensor_that_measures_nothing_is_as_good_as_silent(monkeypatch):
    """10 scans a second; the robot stands when the last usable one is more than a second old."""
    monkeypatch.setattr(rospy, 'Subscriber', lambda *_, **__: SimpleNamespace(resolved_name='/scan'))
    source = SimpleNamespace(data_type='LaserScan', topic='scan', expected_update_rate=0.0)
    sensor = costmaps.Sensor(source, None)
    said = {}
    for tick in range(42):
        now = rospy.Time.from_sec(100.0 + 0.1 * tick)
        monkeypatch.setattr(rospy.Time, 'now', lambda now=now: now)
        if tick < 30:
            sensor._store(LaserScan(range_min=0.1, range_max=8.0, ranges=[1.0 if tick < 10 else math.nan]))
        said[tick] = sensor.silence(now)
    assert said[9] == said[19] == ''  # the last usable scan is that of tick 9
    assert said[20].startswith('no range on /scan is a number') and said[20] == said[38]
    assert said[41].startswith('no message on /scan for')


def test_a_sensor_that_has_never_measured_anything(monkeypatch):
    monkeypatch.setattr(rospy, 'Subscriber', lambda *_, **__: SimpleNamespace(resolved_name='/scan'))
    monkeypatch.setattr(rospy.Time, 'now', lambda: rospy.Time.from_sec(5.0))
    sensor = costmaps.Sensor(SimpleNamespace(data_type='LaserScan', topic='scan', expected_update_rate=None), None)
    assert sensor.silence(rospy.Time.from_sec(5.0)).startswith('no message on /scan yet')
    sensor._store(LaserScan(range_min=0.1, range_max=8.0, ranges=[math.nan]))
    assert sensor.silence(rospy.Time.from_sec(5.0)).startswith('no range on /scan')
