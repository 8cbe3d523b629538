"""rospy_support.servers: how much is logged about peers, and the limit of open files."""
import resource
import threading

import pytest

from rospy_support import servers
from rospy_support.servers import MOST_LINES, PERIOD, REMINDER, Report


@pytest.fixture
def logged(monkeypatch):
    """Report with a clock of its own: (clock, report, lines)."""
    clock, lines = [0.0], []

    class Thread:
        def __init__(self, target, args, daemon):
            self.start = lambda: target(*args)
    monkeypatch.setattr(threading, 'Thread', Thread)
    return clock, Report(lambda: clock[0], lambda text, *values: lines.append(text % values)), lines


def test_a_storm_is_a_few_lines_and_a_number(logged):
    clock, report, lines = logged
    for number in range(1000):
        report('refused', f'peer {number}')
    assert lines == [f'peer {number}' for number in range(MOST_LINES)]
    clock[0] = PERIOD
    report('refused', '100 % wrong')
    assert lines[MOST_LINES:] == [f'100 % wrong ({1000 - MOST_LINES} more lines of this kind were left out.)']


def test_kinds_do_not_hide_each_other(logged):
    _, report, lines = logged
    for _ in range(100):
        report('refused', 'x')
    report('descriptors', 'Too many open files')
    report('descriptors', 'Too many open files')
    assert lines.count('Too many open files') == 1


def test_descriptors_are_named_again_much_later(logged):
    clock, report, lines = logged
    for clock[0] in (0.0, REMINDER - 1.0, REMINDER):
        report('descriptors', 'Too many open files')
    assert len(lines) == 2


@pytest.mark.parametrize('soft, hard, expected', [
    (1024, 4096, (4096, 4096)), (1024, 1 << 20, (servers.MANY_FILES, 1 << 20)), (1 << 17, 1 << 20, None),
    (1024, resource.RLIM_INFINITY, (servers.MANY_FILES, resource.RLIM_INFINITY)), (resource.RLIM_INFINITY, -1, None)])
def test_limit_of_open_files(monkeypatch, soft, hard, expected):
    wanted = []
    monkeypatch.setattr(servers.resource, 'getrlimit', lambda _: (soft, hard))
    monkeypatch.setattr(servers.resource, 'setrlimit', lambda _, limits: wanted.append(limits))
    servers.allow_many_files()
    assert wanted == ([expected] if expected else [])
