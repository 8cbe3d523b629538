"""A client of a bridge without ROS: what its frames do, what it is told, and that it is stopped and cut loose."""
import asyncio
import gc
import json
import warnings

import pytest

from browser_servers.core.encodings import Message
from browser_servers.core.operations import OPERATIONS, Refused
from browser_servers.core.outbox import SMALL
from browser_servers.core.session import HANDLERS, MAX_CALLS, SLOW, Session, Settings
from unit_support.messages import Point

FORWARD, ZERO = {'linear': {'x': 1.0}}, {'linear': {'x': 0.0}}


class FakeBridge:
    """A Bridge that lists in ``done`` what it does; ``/slow`` waits for ``gate``, ``/no`` is refused."""

    def __init__(self):
        self.done, self.gate = [], asyncio.Event()

    def is_velocity(self, topic):
        return topic.endswith('cmd_vel')

    def publish(self, session, topic, values):
        self._note('publish', topic, values)

    def stop(self, topic):
        self._note('stop', topic)

    def respond(self, session, service, request, values, result):
        self._note('respond', service, request, values, result)

    def _note(self, *action):
        if '/no' in action:
            raise Refused('it is not there')
        self.done.append(action)

    def __getattr__(self, name):
        """Return a coroutine function: all other methods of a Bridge are such."""
        async def act(*arguments):
            if '/slow' in arguments:
                await self.gate.wait()
            self._note(name, *(argument for argument in arguments if not isinstance(argument, Session)))
            return {'sum': 3}
        return act


class Client:
    """A Session with both of its ends; ``reading``: whether frames are taken at once."""

    def __init__(self, **settings):
        self.bridge, self.frames, self.closed, self.futures, self.reading = FakeBridge(), [], [], [], True
        self.session = Session(self.bridge, self._send, lambda *why: self.closed.append(why), Settings(**settings))

    def _send(self, frame):
        self.frames.append(frame)
        future = asyncio.get_running_loop().create_future()
        self.futures.append(future)
        if self.reading:
            future.set_result(None)
        return future

    async def send(self, *operations):
        """Send operations, or frames, and let the session work."""
        for operation in operations:
            waiting = self.session.received(operation if isinstance(operation, (str, bytes)) else json.dumps(operation))
            if waiting is not None:
                self.session.drain()
                await waiting
        self.session.drain()
        await self.settle()

    async def settle(self):
        """Let everything run that can."""
        for _ in range(20):
            await asyncio.sleep(0)

    def received(self):
        """Return what was sent since the last call."""
        frames, self.frames[:] = [json.loads(frame) for frame in self.frames], []
        return frames


def with_client(**settings):
    """Run a coroutine function with a Client as a test."""
    def decorate(test):
        def run():
            async def work():
                await asyncio.wait_for(test(Client(**settings)), 10.0)
            asyncio.run(work())
        run.__name__, run.__doc__ = test.__name__, test.__doc__
        return run
    return decorate


def publish(topic, values):
    return {'op': 'publish', 'topic': topic, 'msg': values}


def message(topic='/p', size=10):
    return Message(topic, b'x' * size, lambda data: Point(x=1.0), (0, 0))


def test_every_operation_is_done_by_a_handler_or_holds_another_one():
    assert HANDLERS.keys() - {'refused'} == OPERATIONS.keys() - {'fragment', 'png'}


@with_client()
async def test_operations_reach_the_bridge_in_order(client):
    await client.send({'op': 'advertise', 'topic': '/a', 'type': 't/T', 'latch': True}, publish('/a', {'n': 1}),
                      {'op': 'unadvertise', 'topic': '/a'}, {'op': 'advertise_service', 'service': '/s', 'type': 't/S'},
                      {'op': 'service_response', 'service': '/s', 'id': 'i', 'values': {'a': 1}, 'result': True},
                      {'op': 'unadvertise_service', 'service': '/s'})
    assert client.bridge.done == [
        ('advertise', '/a', 't/T', True, 100), ('publish', '/a', {'n': 1}), ('unadvertise', '/a'),
        ('advertise_service', '/s', 't/S'), ('respond', '/s', 'i', {'a': 1}, True), ('unadvertise_service', '/s')]
    assert client.received() == []


@with_client()
async def test_messages_come_as_they_were_asked_for(client):
    await client.send({'op': 'subscribe', 'topic': '/p', 'id': '1'})
    client.session.deliver(message())
    await client.send({'op': 'subscribe', 'topic': '/p', 'id': '2', 'fragment_size': 20})
    client.session.deliver(message())
    await client.settle()
    whole, *parts = client.received()
    assert whole == {'op': 'publish', 'topic': '/p', 'msg': {'x': 1.0, 'y': 0.0, 'z': 0.0}}
    assert json.loads(''.join(part['data'] for part in parts)) == whole and len(parts) > 2
    await client.send({'op': 'unsubscribe', 'topic': '/p', 'id': '2'})
    client.session.deliver(message())
    assert len(client.received()) == 1 and ('unsubscribe', '/p') not in client.bridge.done
    await client.send({'op': 'unsubscribe', 'topic': '/p'})
    client.session.deliver(message())
    assert client.received() == [] and client.bridge.done[-1] == ('unsubscribe', '/p')


@with_client()
async def test_call_is_answered_with_its_id(client):
    await client.send({'op': 'call_service', 'service': '/add', 'args': [1, 2], 'id': 'c'},
                      {'op': 'call_service', 'service': '/no', 'id': 'd'})
    answer, refusal = client.received()  # no status beside it, which roslibpy would take for an error of its own
    assert answer == {'op': 'service_response', 'service': '/add', 'values': {'sum': 3}, 'result': True, 'id': 'c'}
    assert refusal == {'op': 'service_response', 'service': '/no', 'values': 'it is not there', 'result': False,
                       'id': 'd'}


@with_client()
async def test_parts_of_an_answer_have_the_id_of_the_call(client):
    await client.send({'op': 'call_service', 'service': '/add', 'id': 'c', 'fragment_size': 20})
    parts = client.received()
    assert len(parts) > 2 and {part['id'] for part in parts} == {'c'}
    assert json.loads(''.join(part['data'] for part in parts))['values'] == {'sum': 3}


@with_client()
async def test_types_may_have_the_names_of_ros_2(client):
    await client.send({'op': 'advertise', 'topic': '/a', 'type': 'geometry_msgs/msg/Twist'},
                      {'op': 'subscribe', 'topic': '/b', 'type': 'nav_msgs/msg/Odometry'},
                      {'op': 'subscribe', 'topic': '/c', 'type': 'a/b/c'},
                      {'op': 'advertise_service', 'service': '/s', 'type': 'std_srvs/srv/SetBool'})
    assert [entry[2] for entry in client.bridge.done] == ['geometry_msgs/Twist', 'nav_msgs/Odometry', 'a/b/c',
                                                          'std_srvs/SetBool']


@with_client()
async def test_slow_service_delays_nothing(client):
    await client.send({'op': 'call_service', 'service': '/slow', 'id': '1'}, publish('/a', {}))
    assert client.bridge.done == [('publish', '/a', {})]
    client.bridge.gate.set()
    await client.settle()
    assert client.received()[0]['id'] == '1'


@with_client()
async def test_open_calls_are_bounded(client):
    await client.send(*[{'op': 'call_service', 'service': '/slow'}] * (MAX_CALLS + 1))
    assert [answer['result'] for answer in client.received() if answer['op'] == 'service_response'] == [False]


@with_client()
async def test_zero_velocity_overtakes_a_slow_registration(client):
    await client.send({'op': 'advertise', 'topic': '/slow', 'type': 't/T'}, publish('/other', {}),
                      publish('/cmd_vel', FORWARD), publish('/cmd_vel', ZERO))
    assert client.bridge.done == [('publish', '/cmd_vel', ZERO)]
    client.bridge.gate.set()
    await client.settle()
    assert client.bridge.done[1:] == [('advertise', '/slow', 't/T', False, 100), ('publish', '/other', {})]


@with_client(rate=1e6, burst=1e6)
async def test_zero_velocity_overtakes_a_flood(client):
    for number in range(40):
        client.session.received(json.dumps(publish('/flood', {'n': number})))
        client.session.received(json.dumps(publish('/cmd_vel', FORWARD)))
    client.session.received(json.dumps(publish('/cmd_vel', ZERO)))
    client.session.drain()
    await client.settle()
    assert client.bridge.done[0] == ('publish', '/cmd_vel', ZERO)
    assert [entry[2]['n'] for entry in client.bridge.done[1:]] == list(range(40))


@pytest.mark.parametrize('frame, error', [
    ('nonsense', 'not valid JSON'), (b'\xa1\xff', 'not valid CBOR'),
    ('[' * 50000, 'the message is n'),  # nested too deeply, or not valid JSON: the release of Python decides
    ('{"op": "fly"}', 'unknown operation'), ('{"op": "publish", "topic": "/no"}', 'publish: it is not there'),
    ('{"op": "subscribe", "topic": "/no"}', 'subscribe: it is not there'), ('{"op": "auth"}', 'is not supported'),
    ('{"op": "png", "data": "x"}', 'png: "data" is not'), ('{"op": "publish", "topic": 5}', '"topic" is 5'),
])
def test_bad_frame_is_answered_with_a_status_and_the_next_one_works(frame, error):
    @with_client()
    async def test(client):
        await client.send(frame)
        status, = client.received()
        assert status['op'] == 'status' and status['level'] == 'error' and error in status['msg']
        await client.send(publish('/a', {}))
        assert client.bridge.done == [('publish', '/a', {})] and client.closed == []
    test()


@with_client()
async def test_level_of_statuses(client):
    await client.send({'op': 'set_level', 'level': 'none'}, 'nonsense')
    assert client.received() == []
    await client.send({'op': 'set_level', 'level': 'info'}, {'op': 'subscribe', 'topic': '/a'})
    assert client.received() == [{'op': 'status', 'level': 'info', 'msg': 'Subscribed to /a'}]


@with_client()
async def test_fragments_and_images_become_operations(client):
    from browser_servers.core.encodings import to_png
    text = json.dumps(publish('/a', {'n': 1}))
    await client.send(*[{'op': 'fragment', 'id': 'f', 'num': number, 'total': 2, 'data': part}
                        for number, part in enumerate((text[:9], text[9:]))], {'op': 'png', 'data': to_png(text)})
    assert client.bridge.done == [('publish', '/a', {'n': 1})] * 2


@with_client(topics=('/turtle*',), services=('/spawn',))
async def test_patterns_limit_a_client(client):
    await client.send({'op': 'subscribe', 'topic': '/odom'}, {'op': 'call_service', 'service': '/kill'},
                      {'op': 'subscribe', 'topic': '/turtle1/pose'}, {'op': 'call_service', 'service': '/spawn'})
    assert [entry[:2] for entry in client.bridge.done] == [('subscribe', '/turtle1/pose'), ('call', '/spawn')]
    assert 'the topic /odom is not among those' in client.received()[0]['msg']


@with_client()
async def test_small_messages_pass_a_client_that_is_busy_with_a_large_one(client):
    await client.send({'op': 'subscribe', 'topic': '/image'}, {'op': 'subscribe', 'topic': '/pose'})
    client.reading = False
    client.session.deliver(message('/image', SMALL + 1))
    for _ in range(3):
        client.session.deliver(message('/image', SMALL + 1))
    client.session.deliver(message('/pose'))
    assert [frame['topic'] for frame in client.received()] == ['/image']
    client.reading = True
    client.futures[-1].set_result(None)
    await client.settle()
    assert [frame['topic'] for frame in client.received()] == ['/pose', '/image']


async def stop_reading(client):
    """Let a client read nothing of a topic that it has subscribed to; return the time [s]."""
    await client.send({'op': 'subscribe', 'topic': '/p'})
    client.reading = False
    for _ in range(10000):
        client.session.deliver(message(size=1000))
    return asyncio.get_running_loop().time()  # CLOCK_MONOTONIC, as the session's


@with_client(slow=5.0)
async def test_client_that_reads_nothing_is_cut_loose(client):
    now = await stop_reading(client)
    client.session.check(now + 4.0)
    assert client.closed == [] and len(client.frames) == 1
    client.session.check(now + 6.0)
    assert client.closed == [(SLOW, 'it has not taken a message for 5 s')]


@with_client(slow=5.0)
async def test_client_is_not_slow_while_this_server_is_stalled(client):
    now = await stop_reading(client)
    client.session.check(now + 6.0, stalled=5.9)
    assert client.closed == []
    client.session.check(now + 11.0)
    assert client.closed == [(SLOW, 'it has not taken a message for 5 s')]


@with_client()
async def test_a_client_that_leaves_at_once_leaves_no_call_behind(client):
    gc.collect()  # what earlier tests left behind warns, too
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter('always')
        client.session.received(json.dumps({'op': 'subscribe', 'topic': '/p'}))
        client.session.drain()
        await client.session.closed()
        await client.settle()
        gc.collect()
    assert warned == []


@with_client()
async def test_message_that_cannot_be_read_is_named(client):
    def broken(data):
        raise ValueError('unpack requires 8 bytes')
    await client.send({'op': 'subscribe', 'topic': '/p'})
    client.session.deliver(Message('/p', b'', broken, (0, 0)))
    await client.settle()
    assert 'a message of /p cannot be read: unpack requires' in client.received()[0]['msg']


@with_client(deadman=0.5)
async def test_silent_driver_is_stopped_once(client):
    await client.send(publish('/cmd_vel', FORWARD))
    now = asyncio.get_running_loop().time()
    client.session.check(now + 0.4)
    client.session.check(now + 0.6)
    client.session.check(now + 0.8)
    assert client.bridge.done[1:] == [('stop', '/cmd_vel')]


@with_client()
async def test_driver_that_has_asked_for_it_is_stopped_when_it_goes(client):
    await client.send({'op': 'deadman', 'timeout': 0.5}, publish('/cmd_vel', FORWARD))
    await client.session.closed()
    assert client.bridge.done[1:] == [('stop', '/cmd_vel'), ('leave',)]


@with_client()
async def test_other_drivers_are_left_alone(client):
    await client.send(publish('/cmd_vel', FORWARD))
    await client.session.closed()
    assert client.bridge.done[1:] == [('leave',)]


@with_client(rate=1.0, burst=3.0)
async def test_messages_beyond_the_rate_are_dropped_but_never_a_velocity(client):
    await client.send(*[publish('/flood', {'n': number}) for number in range(5)], publish('/cmd_vel', ZERO))
    assert [entry[1:] for entry in client.bridge.done] == [
        ('/cmd_vel', ZERO), *(('/flood', {'n': number}) for number in range(3))]
    client.session.check(0.0)
    client.session.check(0.0)
    status, = client.received()
    assert status['level'] == 'error' and '2 messages came faster' in status['msg']


@with_client(rate=100.0, burst=2.0)
async def test_client_that_sends_too_fast_has_to_wait(client):
    loop = asyncio.get_running_loop()
    start = loop.time()
    for _ in range(7):
        waiting = client.session.received('{"op": "status"}')
        client.session.drain()
        if waiting is not None:
            await waiting
    assert loop.time() - start > 0.03  # 5 beyond the burst at 100 Hz, less one tick
