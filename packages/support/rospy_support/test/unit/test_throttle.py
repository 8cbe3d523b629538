"""rospy_support.throttle: which lines are due, and when. Wall time is a fake."""
import math
import types

import pytest

from rospy_support import throttle
from rospy_support.throttle import WallThrottle

PERIOD, SHORTER = 10.0, 1.0  # [s]


@pytest.fixture
def clock(monkeypatch):
    wall = types.SimpleNamespace(now=0.0)
    monkeypatch.setattr(throttle.time, 'monotonic', lambda: wall.now)
    return wall


def due(clock, throttled, calls, **options):
    """Return which of the calls, (time [s], kind, text), are due."""
    found = []
    for clock.now, kind, text in calls:
        found.append(throttled.due(kind, text, **options))
    return found


@pytest.mark.parametrize('period, options, calls, wanted', [
    (PERIOD, {}, [(0.0, 'a', ''), (9.9, 'a', ''), (10.0, 'a', ''), (19.9, 'a', ''), (20.0, 'a', '')], '10101'),
    (PERIOD, {}, [(0.0, 'a', ''), (5.0, 'b', ''), (10.0, 'a', ''), (10.0, 'b', ''), (15.0, 'b', '')], '11101'),
    (PERIOD, {}, [(0.0, 'a', 'x'), (5.0, 'a', 'y'), (10.0, 'a', 'z')], '101'),  # another text is not another kind
    (PERIOD, {'changed': SHORTER}, [(0.0, 'a', 'x'), (0.9, 'a', 'y'), (1.0, 'a', 'y'), (2.0, 'a', 'y')], '1010'),
    (PERIOD, {'changed': SHORTER}, [(0.0, 'a', 'x'), (9.9, 'a', 'x'), (10.0, 'a', 'x')], '101'),
    (PERIOD, {'changed': 0.0}, [(0.0, 'a', 'x'), (0.0, 'a', 'y'), (0.0, 'a', 'x'), (9.0, 'a', 'x')], '1110'),
    (math.inf, {}, [(0.0, 'a', ''), (1e9, 'a', ''), (1e9, 'b', '')], '101'),
    (0.0, {}, [(0.0, 'a', ''), (0.0, 'a', '')], '11'),
])
def test_lines_that_are_due(clock, period, options, calls, wanted):
    assert due(clock, WallThrottle(period), calls, **options) == [mark == '1' for mark in wanted]


def test_what_is_forgotten_is_due_at_once(clock):
    throttled = WallThrottle(PERIOD)
    assert throttled.due('a') and throttled.due('b')
    throttled.forget('a')
    throttled.forget('never logged')
    assert throttled.due('a') and not throttled.due('b')


def test_a_warning_is_formatted_and_counts_as_logged(clock, logged):
    throttled = WallThrottle(PERIOD)
    for clock.now in (0.0, 9.9, 10.0):
        throttled.warn('late', '%g s late', clock.now)
    assert logged == ['0 s late', '10 s late']
