"""move_base.costmaps: a sensor that was never heard, is silent, or measures nothing, and its expected_update_rate."""
import math
from types import SimpleNamespace

import pytest
import rospy
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import LaserScan

from move_base import costmaps, settings


@pytest.fixture
def sensor(monkeypatch):
    """Return a function that makes a Sensor with an expected_update_rate; ``warned`` of it has its warnings."""
    monkeypatch.setattr(costmaps.rospy, 'Subscriber', lambda *_, **__: SimpleNamespace(resolved_name='/scan'))

    def make(rate):
        warned = []
        made = costmaps.Sensor(SimpleNamespace(data_type='LaserScan', topic='scan', expected_update_rate=rate),
                               SimpleNamespace(warn=lambda _key, text, *values: warned.append(text % values)))
        made.warned = warned
        return made
    return make


def scan(value):
    return LaserScan(range_min=0.1, range_max=8.0, ranges=[value])


@pytest.mark.parametrize('rate, said', [(None, 'no message on /scan yet'), (0.5, 'no message on /scan yet'), (0.0, '')])
def test_a_sensor_that_was_never_heard(sensor, rate, said):
    """Public parameters of a robot without sensors, such as the fake TurtleBot of ROS by Example, have the rate 0."""
    made = sensor(rate)
    reason = made.silence(rospy.Time(100))
    assert reason.startswith(said) and bool(reason) == bool(said)
    assert bool(made.warned) == (rate == 0.0) and all('/scan' in line for line in made.warned)


@pytest.mark.parametrize('rate, past, silent', [
    (None, 0.9, False), (None, 1.1, True), (0.0, 1.1, True), (2.0, 3.9, False), (2.0, 4.1, True)])
def test_a_sensor_that_was_heard(sensor, rate, past, silent):
    made = sensor(rate)
    made._latest = rospy.Time(10)
    assert bool(made.silence(rospy.Time(10) + rospy.Duration(past))) == silent


def test_a_sensor_that_measures_nothing_is_as_good_as_silent(sensor, monkeypatch):
    """10 scans a second; the robot stands when the last usable one is more than a second old."""
    made, reasons = sensor(0.0), {}
    for tick in range(42):
        now = rospy.Time.from_sec(100.0 + 0.1 * tick)
        monkeypatch.setattr(rospy.Time, 'now', lambda now=now: now)
        if tick < 30:
            made._store(scan(1.0 if tick < 10 else math.nan))
        reasons[tick] = made.silence(now)
    assert reasons[9] == reasons[19] == ''  # the last usable scan is that of tick 9
    assert reasons[20].startswith('no range on /scan is a number') and reasons[20] == reasons[38]
    assert reasons[41].startswith('no message on /scan for')


def test_a_sensor_that_has_never_measured_anything(sensor, monkeypatch):
    monkeypatch.setattr(rospy.Time, 'now', lambda: rospy.Time(5))
    made = sensor(None)
    made._store(scan(math.nan))
    assert made.silence(rospy.Time(5)).startswith('no range on /scan')


def test_a_map_that_is_missing_is_named():
    node = object.__new__(costmaps.CostmapNode)
    node._layers, node.map_topic, node._map, node._new_map = [('', settings.STATIC)], '/ns/map', None, None
    assert node.missing().startswith('no map on /ns/map: start map_server')
    node._new_map = OccupancyGrid()
    assert node.missing() == ''
