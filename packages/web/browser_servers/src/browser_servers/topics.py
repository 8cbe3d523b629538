"""The topics that clients publish and subscribe to.

Threading contract: methods run in the loop's thread unless they say otherwise; those whose name ends in `_slow` ask the
master and run in a thread of an executor, one at a time for each topic. Callbacks of rospy only hand messages over.
"""
import asyncio
import collections
import contextlib
import functools
import socket
import threading
import time
from typing import Any, Awaitable, Callable, Deque, Dict, List, Optional, Protocol, Set, Tuple, TypeVar, Union

import rosgraph.names
import rospy
import rostopic

from browser_servers import types
from browser_servers.core.encodings import Message
from browser_servers.core.inbox import VELOCITIES
from browser_servers.core.operations import Refused
from browser_servers.core.outbox import BURST, SMALL
from rospy_support import rospy_internals
from rospy_support.topics import LatestPublisher, Publisher

CONNECTING = 1.0  # [s] after the registration of a topic in which new subscribers get the messages that they missed
MAX_KEPT = 100  # messages for them
PREFIX = 4  # [B] of a message's length, little-endian
BUFFER_SIZE = 65536  # [B] at first
Slow = Callable[..., Awaitable[Any]]  # slow(function, *arguments): a coroutine that runs a function in another thread
Header = Dict[str, str]  # of a TCPROS connection
Result = TypeVar('Result')


class Subscriber(Protocol):
    """Who subscribes to a topic, such as a Session."""

    def deliver(self, message: Message, kept: bool = False) -> None:
        """Take a message; ``kept``: the topic is latched."""


class _Starting(rospy.SubscribeListener):
    """Gives the first messages to subscribers that connect just after them."""

    def __init__(self) -> None:
        super().__init__()
        self._end, self._lock = time.monotonic() + CONNECTING, threading.Lock()
        self._kept: List[Any] = []

    def keep(self, message: Any) -> None:
        """Keep a message, before it is published."""
        if self._end:
            with self._lock:
                if time.monotonic() < self._end and len(self._kept) < MAX_KEPT:
                    self._kept.append(message)
                elif time.monotonic() >= self._end:
                    self._end, self._kept = 0.0, []

    def peer_subscribe(self, topic_name: str, topic_publish: Any, peer_publish: Callable[[Any], None]) -> None:
        """Send the kept messages to a new subscriber, called by rospy; older velocities are out of date."""
        with self._lock:
            kept = list(self._kept) if time.monotonic() < self._end else []
        for message in kept:
            peer_publish(message)


class Incoming:
    """Reads the messages of one publisher in the loop: a TCPROS connection after its handshake."""

    def __init__(self, loop: asyncio.AbstractEventLoop, connection: socket.socket, rest: bytes,
                 deliver: Callable[[bytes], None], ended: Callable[[], None]) -> None:
        """Read ``connection`` (a socket, closed at the end) after the bytes ``rest``.

        ``deliver`` gets the bytes of each message; ``ended`` is called once at the end.
        """
        self._loop, self._connection, self._deliver, self._ended = loop, connection, deliver, ended
        self._data, self._filled = bytearray(max(BUFFER_SIZE, 2 * len(rest))), len(rest)
        self._data[:len(rest)] = rest
        connection.setblocking(False)
        loop.add_reader(connection, self._readable)
        self._take()

    def _readable(self) -> None:
        try:
            with memoryview(self._data) as view:
                size = self._connection.recv_into(view[self._filled:])
        except BlockingIOError:
            return
        except OSError:
            size = 0
        if not size:
            self._end()
            return
        self._filled += size
        self._take()

    def _take(self) -> None:
        begin = 0
        with memoryview(self._data) as view:
            while self._filled - begin >= PREFIX:
                end = begin + PREFIX + int.from_bytes(view[begin:begin + PREFIX], 'little')
                if end > self._filled:
                    break
                self._deliver(bytes(view[begin + PREFIX:end]))
                begin = end
            left = self._filled - begin
            if begin:
                view[:left] = view[begin:self._filled]
        self._filled = left
        if left == len(self._data):
            self._data += bytes(left)

    def _end(self) -> None:
        self._loop.remove_reader(self._connection)
        with contextlib.suppress(OSError):
            self._connection.close()
        self._ended()


class Advertised:
    """A topic that clients publish on."""

    def __init__(self, name: str, kind: str, latch: bool, queue_size: int) -> None:
        self.kind, self.cls = kind, types.message_class(kind)
        self.sessions: Set[object] = set()
        self.is_velocity = kind in VELOCITIES
        self.unregistering: Optional[asyncio.TimerHandle] = None
        self._starting = None if latch else _Starting()
        self._publisher: Union[Publisher, LatestPublisher]
        if latch:
            self._publisher = Publisher(name, self.cls, latch=True, queue_size=max(1, queue_size), tcp_nodelay=True)
        else:
            self._publisher = LatestPublisher(name, self.cls, self._starting)

    def publish(self, values: Any) -> None:
        message = types.builder.build(self.cls, values)
        if self._starting is not None:
            self._starting.keep(message)
        self._publisher.publish(message)

    def unregister(self) -> None:
        self._publisher.unregister()


class Subscribed:
    """A topic that clients subscribe to: hands serialised messages over to the loop, of large ones only the newest."""

    def __init__(self, name: str, kind: str, loop: asyncio.AbstractEventLoop) -> None:
        """``kind``: the type, '' for any."""
        self.kind = kind
        self.sessions: Set[Subscriber] = set()
        self._name, self._loop, self._lock = name, loop, threading.Lock()
        self._waiting: Deque[Tuple[Message, bool]] = collections.deque(maxlen=BURST)
        self._latched: Dict[Optional[str], Message] = {}
        self._subscriber: Any = None

    def register(self) -> None:
        """Register it; messages come from now on."""
        self._subscriber = rospy.Subscriber(self._name, types.raw_class_of(self.kind), self._received, tcp_nodelay=True,
                                            buff_size=1 << 22)

    def _received(self, raw: Any) -> None:
        """Take the first messages of a publisher, called by rospy; later ones are read in the loop."""
        header = rospy_internals.connection_header(raw)
        make = self._maker(header)
        if self._subscriber is not None:
            rospy_internals.take_over(self._subscriber, raw, functools.partial(self._read_in_loop, make, header))
        message, latched = make(raw._buff), header.get('latching') == '1'
        with self._lock:
            if latched:
                self._latched[header.get('callerid')] = message
            elif len(message.data) > SMALL:
                self._waiting = collections.deque(
                    (entry for entry in self._waiting if len(entry[0].data) <= SMALL), BURST)
            scheduled = bool(self._waiting)
            self._waiting.append((message, latched))
        if not scheduled:
            self._loop.call_soon_threadsafe(self._deliver)

    def _maker(self, header: Header) -> Callable[[bytes], Message]:
        """Return a function that makes a Message of the bytes from a connection with this header."""
        kind, definition = header.get('type', self.kind), header.get('message_definition', '')
        deserialise = functools.partial(types.deserialise, kind, definition)
        return lambda data: Message(self._name, data, deserialise, types.now())

    def _read_in_loop(self, make: Callable[[bytes], Message], header: Header, connection: socket.socket,
                      rest: bytes) -> None:
        """Read a connection in the loop until it ends; without a change of threads messages arrive sooner."""
        latched, ended = header.get('latching') == '1', threading.Event()

        def deliver(data: bytes) -> None:
            message = make(data)
            if latched:
                with self._lock:
                    self._latched[header.get('callerid')] = message
            for session in list(self.sessions):
                session.deliver(message, latched)
        self._loop.call_soon_threadsafe(functools.partial(Incoming, self._loop, connection, rest, deliver, ended.set))
        ended.wait()

    def _deliver(self) -> None:
        with self._lock:
            messages, self._waiting = self._waiting, collections.deque(maxlen=BURST)
        for message, latched in messages:
            for session in self.sessions:
                session.deliver(message, latched)

    def deliver_latched(self, session: Subscriber) -> None:
        """Send a later client the latched messages, as ROS does for a new subscriber."""
        with self._lock:
            latched = list(self._latched.values())
        for message in latched:
            session.deliver(message, True)

    def unregister(self) -> None:
        if self._subscriber is not None:
            self._subscriber.unregister()


class Topics:
    """The topics of all clients."""

    def __init__(self, loop: asyncio.AbstractEventLoop, slow: Slow, unregister_timeout: float) -> None:
        """``unregister_timeout`` [s] that a topic stays advertised after its last client."""
        self._loop, self._slow, self._timeout = loop, slow, unregister_timeout
        self._advertised: Dict[str, Advertised] = {}
        self._subscribed: Dict[str, Subscribed] = {}
        self._locks: Dict[str, asyncio.Lock] = collections.defaultdict(asyncio.Lock)

    def is_velocity(self, topic: str) -> bool:
        advertised = self._advertised.get(topic)
        return advertised is not None and advertised.is_velocity

    def stop(self, topic: str) -> None:
        """Publish a zero velocity, unless the topic is no longer advertised."""
        advertised = self._advertised.get(topic)
        if advertised is not None:
            advertised.publish({})

    def publish(self, session: object, topic: str, values: Any) -> Optional[Awaitable[None]]:
        """Publish; return a coroutine if the master must be asked for the type first."""
        advertised = self._advertised.get(topic)
        if advertised is None:
            return self._publish_unadvertised(session, topic, values)
        advertised.sessions.add(session)
        advertised.publish(values)
        return None

    async def _publish_unadvertised(self, session: object, topic: str, values: Any) -> None:
        kind = await self._slow(_type_of_slow, topic)
        if not kind:
            raise Refused(f'the type of {topic} is not known: nobody publishes it or subscribes to it. Advertise it '
                          'first: {"op": "advertise", "topic": "' + topic + '", "type": "..."}')
        await self.advertise(session, topic, kind, False, 100)
        self._advertised[topic].publish(values)

    async def advertise(self, session: object, topic: str, kind: str, latch: bool, queue_size: int) -> None:
        async with self._locks[topic]:
            advertised = self._advertised.get(topic)
            if advertised is None:
                other = await self._slow(_type_of_slow, topic)
                _compare(topic, kind, other)
                advertised = await self._slow(_guarded, Advertised, topic, kind, latch, queue_size)
                self._advertised[topic] = advertised
            _compare(topic, kind, advertised.kind)
            if advertised.unregistering is not None:
                advertised.unregistering.cancel()
                advertised.unregistering = None
            advertised.sessions.add(session)

    async def unadvertise(self, session: object, topic: str) -> None:
        """End a client's publishing; the topic stays for a while, for clients that come again."""
        async with self._locks[topic]:
            advertised = self._advertised.get(topic)
            if advertised is None:
                return
            advertised.sessions.discard(session)
            if not advertised.sessions and advertised.unregistering is None:
                advertised.unregistering = self._loop.call_later(
                    self._timeout, self._unregister_soon, topic, advertised)

    def _unregister_soon(self, topic: str, advertised: Advertised) -> None:
        self._loop.create_task(self._unregister(topic, advertised))

    async def _unregister(self, topic: str, advertised: Advertised) -> None:
        async with self._locks[topic]:
            if not advertised.sessions and self._advertised.get(topic) is advertised:
                del self._advertised[topic]
                await self._slow(advertised.unregister)

    async def subscribe(self, session: Subscriber, topic: str, kind: Optional[str]) -> None:
        async with self._locks[topic]:
            if kind:
                types.message_class(kind)
            subscribed = self._subscribed.get(topic)
            if subscribed is None:
                other = await self._slow(_type_of_slow, topic)
                _compare(topic, kind, other)
                subscribed = Subscribed(topic, kind or other, self._loop)
                subscribed.sessions.add(session)
                await self._slow(_guarded, subscribed.register)
                self._subscribed[topic] = subscribed
                return
            _compare(topic, kind, subscribed.kind)
            if session not in subscribed.sessions:
                subscribed.sessions.add(session)
                subscribed.deliver_latched(session)

    async def unsubscribe(self, session: Subscriber, topic: str) -> None:
        async with self._locks[topic]:
            subscribed = self._subscribed.get(topic)
            if subscribed is not None:
                subscribed.sessions.discard(session)
                if not subscribed.sessions:
                    del self._subscribed[topic]
                    await self._slow(subscribed.unregister)

    async def leave(self, session: Subscriber) -> None:
        for topic in [topic for topic, entry in self._advertised.items() if session in entry.sessions]:
            await self.unadvertise(session, topic)
        for topic in [topic for topic, entry in self._subscribed.items() if session in entry.sessions]:
            await self.unsubscribe(session, topic)


def _type_of_slow(name: str) -> str:
    if not rosgraph.names.is_legal_name(name):
        raise Refused(f'{name!r} is not a valid topic name: it may contain only letters, digits, _ and /')
    try:
        return rostopic.get_topic_type(name)[0] or ''
    except (rostopic.ROSTopicException, OSError) as error:
        raise Refused(f'the ROS master does not answer ({error}); start roscore') from None


def _guarded(function: Callable[..., Result], *arguments: Any) -> Result:
    """Call a function that registers something; turn its errors into Refused."""
    try:
        return function(*arguments)
    except (rospy.ROSException, ValueError, OSError) as error:
        raise Refused(str(error)) from None


def _compare(name: str, kind: Optional[str], other: str) -> None:
    if kind and other and kind != other and other != '*':
        raise Refused(f'the type of {name} is {other}, not {kind}')
