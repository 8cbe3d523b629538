"""Messages between rospy's threads and the loop: those for new subscribers, and the order of those for clients."""
import asyncio
import threading
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


def test_messages_of_a_thread_reach_clients_in_order(monkeypatch):
    """The oldest of too many messages are dropped, never the last."""
    monkeypatch.setattr(topics.types, 'now', lambda: (0, 0))
    count, got = 3000, []

    async def work():
        loop, done = asyncio.get_running_loop(), asyncio.Event()

        def deliver(message, latched):
            got.append(int(message.data))
            if got[-1] == count - 1:
                done.set()
        subscribed = topics.Subscribed('/numbers', 'std_msgs/String', loop)
        subscribed.sessions = [types.SimpleNamespace(deliver=deliver)]

        def publish():
            for number in range(count):
                header = {'type': 'std_msgs/String', 'callerid': '/talker'}
                subscribed._received(types.SimpleNamespace(_buff=b'%d' % number, _connection_header=header))
        threading.Thread(target=publish, daemon=True).start()
        await asyncio.wait_for(done.wait(), 20.0)
    asyncio.run(work())
    assert got == sorted(set(got))
