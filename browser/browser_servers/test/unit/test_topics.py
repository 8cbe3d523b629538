"""What a topic of a client gives to subscribers that connect just after it was advertised."""
import types

from browser_servers import topics


def test_only_who_connects_at_once_gets_what_was_published_before(monkeypatch):
    now, got = [100.0], []
    monkeypatch.setattr(topics, 'time', types.SimpleNamespace(monotonic=lambda: now[0]))
    starting = topics._Starting()
    starting.keep('forward')
    now[0] += 0.9 * topics.CONNECTING
    starting.peer_subscribe('/turtle1/cmd_vel', None, got.append)
    assert got == ['forward']
    now[0] += topics.CONNECTING  # a simulator that starts later must not drive
    starting.peer_subscribe('/turtle1/cmd_vel', None, got.append)
    assert got == ['forward']
