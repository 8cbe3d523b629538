"""sim_ros.clock: when ~clock_status is published, and when it warns of a slow pace. Wall time is a fake."""
import math
import types

import pytest
import rospy

from rospy_support.throttle import WallThrottle
from sim_ros import clock
from sim_ros.clock import STATUS_PERIOD, WINDOW, StatusReporter

STEP = 0.02  # [s]


class Publisher:
    """Keeps published messages as (steps, pace, paused, late_steps, busy)."""

    def __init__(self, name, *_, **__):
        self.resolved_name, self.published = name, []

    def publish(self, steps, time, rate, pace, paused, lockstep, late, busy):
        self.published.append((steps, pace, paused, late, busy))


@pytest.fixture
def wall(monkeypatch):
    fake = types.SimpleNamespace(now=100.0)
    monkeypatch.setattr(clock.time, 'monotonic', lambda: fake.now)
    monkeypatch.setattr(clock, 'Publisher', Publisher)
    return fake


@pytest.fixture
def warnings(monkeypatch):
    lines = []
    monkeypatch.setattr(rospy, 'logwarn', lambda text, *values: lines.append(text % values))
    return lines


def reporter(rate, lockstep=False, followed=True):
    """Return (pacer, StatusReporter, its published messages)."""
    pacer = types.SimpleNamespace(steps=0, step=STEP, rate=rate, paused=False, nanoseconds=0)
    made = StatusReporter(pacer, lockstep, WallThrottle(math.inf), followed)
    return pacer, made, made._publisher.published


def test_a_status_is_published_at_each_change_and_every_second(wall):
    pacer, status, published = reporter(2.0)
    status.report(0, '')
    assert published == [(0, 0.0, False, 0, '')]
    for _ in range(100):  # 1 s at twice the pace of the wall clock
        wall.now += STATUS_PERIOD / 100
        pacer.steps += 1
        status.report(0, '')
    assert published[1:] == [(100, pytest.approx(2.0), False, 0, '')]
    pacer.paused = True
    status.report(0, '')
    status.report(3, '/busy')
    status.report(4, '/busy')  # the late step was reported before
    assert [(paused, late, busy) for _, _, paused, late, busy in published[2:]] == [(True, 0, ''), (True, 3, '/busy')]


def run(wall, pacer, status, steps):
    """Let as many steps pass in each of the next periods as ``steps`` has."""
    for number in steps:
        wall.now += STATUS_PERIOD
        pacer.steps += number
        status.report(0, '')


@pytest.mark.parametrize('rate, steps, lockstep, paused, warns', [
    (10.0, 449, False, False, True),  # 449 steps of 0.02 s in a second are 8.98 times the wall clock: below 0.9 * 10
    (10.0, 451, False, False, False), (10.0, 100, True, False, False), (10.0, 100, False, True, False),
    (math.inf, 100, False, False, False)])
def test_a_pace_below_the_requested_one_causes_a_warning(wall, warnings, rate, steps, lockstep, paused, warns):
    pacer, status, _ = reporter(rate, lockstep)
    pacer.paused = paused
    status.report(0, '')
    run(wall, pacer, status, WINDOW * [steps])
    assert bool(warnings) == warns
    assert not warnings or 'Time passes 9.0 times as fast as the wall clock, although ~rate is 10:' in warnings[0]


def test_a_short_stall_causes_none(wall, warnings):
    pacer, status, published = reporter(1.0, followed=False)
    status.report(0, '')
    run(wall, pacer, status, 3 * [10, 10, 10, 10, 150])  # of 50 a second: slow for 4 s, then caught up
    assert warnings == []
    assert [round(pace, 1) for _, pace, *_ in published[1:6]] == [0.2, 0.2, 0.2, 0.2, 3.0]


@pytest.mark.parametrize('followed, said', [(True, 'does not change what nodes'), (False, 'becomes too short')])
def test_the_warning_says_what_it_means_for_other_nodes(wall, warnings, followed, said):
    pacer, status, _ = reporter(1.0, followed=followed)
    status.report(0, '')
    run(wall, pacer, status, [30] * WINDOW)
    assert 'Time passes 0.6 times' in warnings[0] and said in warnings[0]
