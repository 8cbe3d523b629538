"""move_base.costmaps: a sensor that was never heard, or is silent, and what its expected_update_rate allows."""
from types import SimpleNamespace

import pytest
import rospy

from move_base import costmaps


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


@pytest.mark.parametrize('rate, said', [(None, 'no message on /scan yet'), (0.5, 'no message on /scan yet'), (0.0, '')])
def test_a_sensor_that_was_never_heard(sensor, rate, said):
    """Public parameters of a robot without sensors, such as the fake TurtleBot of ROS by Example, have the rate 0."""
    made = sensor(rate)
    told = made.silence(rospy.Time(100))
    assert told.startswith(said) and bool(told) == bool(said)
    assert bool(made.warned) == (rate == 0.0) and all('/scan' in line for line in made.warned)


@pytest.mark.parametrize('rate, past, silent', [
    (None, 0.9, False), (None, 1.1, True), (0.0, 1.1, True), (2.0, 3.9, False), (2.0, 4.1, True)])
def test_a_sensor_that_was_heard(sensor, rate, past, silent):
    made = sensor(rate)
    made._latest = rospy.Time(10)
    assert bool(made.silence(rospy.Time(10) + rospy.Duration(past))) == silent
