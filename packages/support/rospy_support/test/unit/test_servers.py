"""rospy_support.servers: how much is logged about peers, the limit of open files, and an unknown rospy."""
import resource
import threading
import types

import pytest

from rospy_support import rospy_internals, servers, throttle
from rospy_support.servers import AGAIN, NEXT, REMINDER, Report


@pytest.fixture
def logged(monkeypatch):
    """Report with a fake clock: (clock, report, lines)."""
    clock, lines = types.SimpleNamespace(now=0.0), []

    class Thread:
        def __init__(self, target, args, daemon):
            self.start = lambda: target(*args)
    monkeypatch.setattr(threading, 'Thread', Thread)
    monkeypatch.setattr(throttle.time, 'monotonic', lambda: clock.now)
    return clock, Report(lambda text, *values: lines.append(text % values)), lines


def test_a_storm_is_a_few_lines(logged):
    clock, report, lines = logged
    for number in range(1000):
        report('refused', f'peer {number}')
    clock.now = NEXT
    for _ in range(1000):
        report('refused', '100 % wrong')
    assert lines == ['peer 0', '100 % wrong']
    clock.now = NEXT + AGAIN
    report('refused', '100 % wrong')
    assert lines[2:] == ['100 % wrong']


def test_descriptors_are_named_beside_others_and_again_much_later(logged):
    clock, report, lines = logged
    report('refused', 'x')
    for clock.now in (0.0, REMINDER - 1.0, REMINDER):
        report('descriptors', 'Too many open files')
    assert lines == ['x', 'Too many open files', 'Too many open files']


def test_an_unknown_rospy_keeps_its_servers(monkeypatch, capsys):
    monkeypatch.setattr(servers, 'allow_many_files', lambda: None)
    monkeypatch.setattr(rospy_internals, 'misfits', lambda: ['rospy.x is missing'])
    for name in ('replace_tcpros_server', 'replace_slave_server', 'limit_publishers', 'tell_connections_apart'):
        monkeypatch.setattr(rospy_internals, name, lambda *_: pytest.fail('rospy is changed'))
    servers.protect.__wrapped__()
    assert 'rospy.x is missing' in capsys.readouterr().err


@pytest.mark.parametrize('soft, hard, expected', [
    (1024, 4096, (4096, 4096)), (1024, 1 << 20, (servers.MANY_FILES, 1 << 20)), (1 << 17, 1 << 20, None),
    (1024, resource.RLIM_INFINITY, (servers.MANY_FILES, resource.RLIM_INFINITY)), (resource.RLIM_INFINITY, -1, None)])
def test_limit_of_open_files(monkeypatch, soft, hard, expected):
    wanted = []
    monkeypatch.setattr(servers.resource, 'getrlimit', lambda _: (soft, hard))
    monkeypatch.setattr(servers.resource, 'setrlimit', lambda _, limits: wanted.append(limits))
    servers.allow_many_files()
    assert wanted == ([expected] if expected else [])
