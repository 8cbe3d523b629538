"""Messages of publishers and clients: in any pieces, in order, kept for new subscribers; topics that have ended."""
import asyncio
import gc
import socket
import threading
import types
import warnings

import pytest

from browser_servers import topics
from browser_servers.topics import BUFFER_SIZE, Incoming

MESSAGES = [b'', b'a', b'x' * 1000, bytes(range(256)) * 2000, b'b' * (3 * BUFFER_SIZE), b'last']
STREAM = b''.join(len(message).to_bytes(4, 'little') + message for message in MESSAGES)


@pytest.mark.parametrize('first, step', [(0, len(STREAM)), (0, 5000), (3, 4999), (1009, 70000), (len(STREAM), 1)])
def test_messages_arrive_whole_and_in_order(first, step):
    async def work():
        ours, theirs = socket.socketpair()
        loop, received, ended = asyncio.get_running_loop(), [], asyncio.Event()
        Incoming(loop, ours, STREAM[:first], received.append, ended.set)
        theirs.setblocking(False)
        for begin in range(first, len(STREAM), step):
            await loop.sock_sendall(theirs, STREAM[begin:begin + step])
            await asyncio.sleep(0)
        theirs.close()
        await asyncio.wait_for(ended.wait(), 10.0)
        assert received == MESSAGES and ours.fileno() == -1
    asyncio.run(work())


def test_a_vehicle_is_stopped_on_its_topic_and_on_no_topic_that_has_ended():
    async def work():
        made, published = topics.Topics(asyncio.get_running_loop(), None, 0.0), []
        made._advertised['/cmd_vel'] = types.SimpleNamespace(publish=published.append)
        with warnings.catch_warnings(record=True) as warned:
            warnings.simplefilter('always')
            for topic in ('/cmd_vel', '/ended/cmd_vel'):
                made.stop(topic)
            gc.collect()
        assert (published, warned) == ([{}], [])  # no coroutine that nobody awaits
    gc.collect()
    asyncio.run(work())


def test_only_who_connects_at_once_gets_what_was_published_before(monkeypatch):
    now, received = [100.0], []
    monkeypatch.setattr(topics, 'time', types.SimpleNamespace(monotonic=lambda: now[0]))
    starting = topics._Starting()
    starting.keep('forward')
    now[0] += 0.9 * topics.CONNECTING
    starting.peer_subscribe('/turtle1/cmd_vel', None, received.append)
    assert received == ['forward']
    now[0] += topics.CONNECTING  # a simulator that starts later must not drive
    starting.peer_subscribe('/turtle1/cmd_vel', None, received.append)
    assert received == ['forward']


def test_messages_of_a_thread_reach_clients_in_order(monkeypatch):
    """The oldest of too many messages are dropped, never the last."""
    monkeypatch.setattr(topics.types, 'now', lambda: (0, 0))
    count, received = 3000, []

    async def work():
        loop, done = asyncio.get_running_loop(), asyncio.Event()

        def deliver(message, latched):
            received.append(int(message.data))
            if received[-1] == count - 1:
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
    assert received == sorted(set(received))
