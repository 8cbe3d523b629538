"""sim_ros.status_reporter: when ~clock_status is published, and when a pace is complained of. Wall time is a fake."""
import math
import types

import pytest
import rospy

from rospy_support.throttle import WallThrottle
from sim_ros import status_reporter
from sim_ros.status_reporter import PERIOD, StatusReporter

STEP = 0.02  # [s]


class Publisher:
    """Keeps published messages as (steps, pace, paused, late_steps, busy)."""

    def __init__(self, name, *_, **__):
        self.resolved_name, self.published = name, []

    def publish(self, steps, time, rate, pace, paused, lockstep, late, busy):
        self.published.append((steps, pace, paused, late, busy))


@pytest.fixture
def wall(monkeypatch):
    clock = types.SimpleNamespace(now=100.0)
    monkeypatch.setattr(status_reporter.time, 'monotonic', lambda: clock.now)
    monkeypatch.setattr(status_reporter, 'Publisher', Publisher)
    return clock


@pytest.fixture
def warnings(monkeypatch):
    lines = []
    monkeypatch.setattr(rospy, 'logwarn', lambda text, *values: lines.append(text % values))
    return lines


def reporter(rate, lockstep=False, periodic=True):
    """Return (pacer, StatusReporter, its published messages)."""
    pacer = types.SimpleNamespace(steps=0, step=STEP, rate=rate, paused=False, nanoseconds=0)
    made = StatusReporter(pacer, lockstep, periodic, WallThrottle(math.inf))
    return pacer, made, made._publisher.published


def test_a_status_is_published_at_each_change_and_every_second(wall):
    pacer, status, published = reporter(2.0)
    status.report(0, '')
    assert published == [(0, 0.0, False, 0, '')]
    for _ in range(100):  # 1 s at twice the pace of the wall clock
        wall.now += PERIOD / 100
        pacer.steps += 1
        status.report(0, '')
    assert published[1:] == [(100, pytest.approx(2.0), False, 0, '')]
    pacer.paused = True
    status.report(0, '')
    status.report(3, '/busy')
    status.report(4, '/busy')  # the late step was reported before
    assert [(paused, late, busy) for _, _, paused, late, busy in published[2:]] == [(True, 0, ''), (True, 3, '/busy')]


def test_without_a_clock_of_its_own_only_changes_are_published(wall):
    pacer, status, published = reporter(1.0, periodic=False)
    status.report(0, '')
    wall.now += 10.0 * PERIOD
    status.report(0, '')
    assert len(published) == 1
    pacer.paused = True
    status.report(0, '')
    assert len(published) == 2


@pytest.mark.parametrize('rate, steps, lockstep, paused, complains', [
    (10.0, 449, False, False, True),  # 449 steps of 0.02 s in a second are 8.98 times the wall clock: below 0.9 * 10
    (10.0, 451, False, False, False), (10.0, 100, True, False, False), (10.0, 100, False, True, False),
    (math.inf, 100, False, False, False)])
def test_a_pace_below_the_one_asked_for_is_complained_of(wall, warnings, rate, steps, lockstep, paused, complains):
    pacer, status, _ = reporter(rate, lockstep)
    pacer.paused = paused
    status.report(0, '')
    wall.now += PERIOD
    pacer.steps = steps
    status.report(0, '')
    assert bool(warnings) == complains
    assert not warnings or 'Time passes 9.0 times as fast as the wall clock, although ~rate is 10.' in warnings[0]
