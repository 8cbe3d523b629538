"""Nodes on a wall clock that is set forward or back by an hour: times that they measure are not those of the clock."""
import threading
import time
from types import SimpleNamespace

import pytest
import rospy

from rospy_support import rospy_internals
from turtle_robotont.nodes.ar_control import MarkerDriver
from turtle_robotont.nodes.robot_driver import step_time

HOUR = 3600.0  # [s]


@pytest.mark.parametrize('before, stamp, step', [
    (10.0, 10.033, pytest.approx(0.033)), (10.0, 10.0, 0.0), (10.0, 10.0 + HOUR, 0.5), (10.0 + HOUR, 10.0, 0.0),
])
def test_the_time_between_two_stamps(before, stamp, step):
    assert step_time(before, stamp, 0.5) == step


@pytest.mark.parametrize('jump', [HOUR, -HOUR])
def test_durations_are_measured_by_a_clock_that_nobody_sets(monkeypatch, jump):
    monkeypatch.setattr(rospy_internals, 'is_wall_time', lambda: True)
    begin, real = rospy_internals.steady_time(), time.time
    monkeypatch.setattr(time, 'time', lambda: real() + jump)
    assert 0.0 <= rospy_internals.steady_time() - begin < 60.0


def test_simulated_time_is_measured_as_it_is(monkeypatch):
    monkeypatch.setattr(rospy_internals, 'is_wall_time', lambda: False)
    monkeypatch.setattr(rospy, 'get_time', lambda: 12.5)
    assert rospy_internals.steady_time() == 12.5


class Behaviour:
    """Keeps what it is stepped by."""

    status = 'driving'

    def __init__(self):
        self.steps = []

    def step(self, dt):
        self.steps.append(dt)


@pytest.mark.parametrize('jump, step', [(0.1, 0.1), (HOUR, 0.3), (-HOUR, 0.0)])
def test_a_behaviour_is_stepped_by_few_periods_at_most(jump, step):
    driver, behaviour = MarkerDriver.__new__(MarkerDriver), Behaviour()
    driver.__dict__.update(_behaviour=behaviour, _lock=threading.Lock(), _ended=False, _status='driving',
                           _longest_step=0.3, _on_step=lambda: None)
    last = rospy.Time.from_sec(2 * HOUR)
    driver._step(SimpleNamespace(last_real=last, current_real=last + rospy.Duration.from_sec(jump)))
    assert behaviour.steps == [pytest.approx(step)]
