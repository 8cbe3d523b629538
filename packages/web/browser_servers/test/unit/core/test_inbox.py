"""Velocities first, the newest only; the rest in order."""
import pytest

from browser_servers.core.inbox import MAX_BYTES, MAX_MESSAGES, MAX_OPERATIONS, Inbox, is_zero

ZERO = {'linear': {'x': 0, 'y': 0.0}, 'angular': {}}
FORWARD = {'linear': {'x': 0.5}, 'angular': {'z': 0}}


def publish(topic, message):
    return {'op': 'publish', 'topic': topic, 'msg': message}


@pytest.mark.parametrize('twist, zero', [
    (ZERO, True), ({}, True), (FORWARD, False), ({'angular': {'z': -0.1}}, False), ({'twist': ZERO}, True),
    ({'twist': FORWARD}, False), ({'linear': 5}, False), ([], False), ({'linear': {'x': None}}, True),
])
def test_zero_velocity_is_recognised(twist, zero):
    assert is_zero(twist) is zero


def test_zero_velocity_overtakes_everything():
    inbox = Inbox()
    for number in range(100):
        inbox.put('publish', publish('/image', {'n': number}), False)
        inbox.put('publish', publish('/turtle1/cmd_vel', FORWARD), True)
        inbox.put('publish', publish('/cmd_vel', FORWARD), True)
    inbox.put('publish', publish('/cmd_vel', ZERO), True)
    assert inbox.take() == ('publish', publish('/cmd_vel', ZERO))
    assert inbox.take() == ('publish', publish('/turtle1/cmd_vel', FORWARD))
    assert [inbox.take()[1]['msg']['n'] for _ in range(100)] == list(range(100))
    assert inbox.take() is None and len(inbox) == 0


def test_client_waits_when_much_is_to_do():
    inbox = Inbox()
    for _ in range(MAX_OPERATIONS):
        assert not inbox.full
        inbox.put('status', {'op': 'status'}, False)
    assert inbox.full


def test_oldest_messages_are_dropped_and_nothing_else():
    inbox = Inbox()
    inbox.put('advertise', {'op': 'advertise'}, False, 10)
    dropped = sum(inbox.put('publish', publish('/flood', {'n': n}), False, 10) for n in range(MAX_MESSAGES + 3))
    assert dropped == 3 and not inbox.full
    assert inbox.take()[0] == 'advertise' and inbox.take()[1]['msg'] == {'n': 3}
    assert inbox.put('publish', publish('/flood', {}), False, 10) == 0  # there is room again


def test_large_messages_do_not_pile_up():
    inbox = Inbox()
    dropped = sum(inbox.put('publish', publish('/image', {'n': number}), False, MAX_BYTES // 2) for number in range(5))
    assert (dropped, len(inbox)) == (3, 2)
    inbox.put('publish', publish('/cmd_vel', ZERO), True, 100)
    assert inbox.take()[1]['topic'] == '/cmd_vel'
