"""The topics that clients publish and subscribe to.

Threading contract: methods run in the loop's thread unless they say otherwise; those whose name ends in `_slow` ask the
master and run in a thread of an executor, one at a time for each topic. Callbacks of rospy only hand messages over.
"""
import asyncio
import collections
import functools
import threading
import time

import rosgraph.names
import rospy
import rostopic

from browser_servers import types
from browser_servers.core.encodings import Message
from browser_servers.core.inbox import VELOCITIES
from browser_servers.core.operations import Refused
from browser_servers.core.outbox import BURST, SMALL
from browser_servers.incoming import Incoming
from rospy_support import rospy_internals
from rospy_support.topics import LatestPublisher, Publisher

CONNECTING = 1.0  # [s] after the registration of a topic in which new subscribers get the messages that they missed
MAX_KEPT = 100  # messages for them


class _Starting(rospy.SubscribeListener):
    """Gives the first messages to subscribers that connect just after them."""

    def __init__(self):
        super().__init__()
        self._end, self._kept, self._lock = time.monotonic() + CONNECTING, [], threading.Lock()

    def keep(self, message):
        """Keep a message, before it is published."""
        if self._end:
            with self._lock:
                if time.monotonic() < self._end and len(self._kept) < MAX_KEPT:
                    self._kept.append(message)
                elif time.monotonic() >= self._end:
                    self._end, self._kept = 0.0, []

    def peer_subscribe(self, topic_name, topic_publish, peer_publish):
        """Send the kept messages to a new subscriber, called by rospy; older velocities are out of date."""
        with self._lock:
            kept = list(self._kept) if time.monotonic() < self._end else []
        for message in kept:
            peer_publish(message)


class Advertised:
    """A topic that clients publish on."""

    def __init__(self, name, kind, latch, queue_size):
        self.kind, self.cls, self.sessions = kind, types.message_class(kind), set()
        self.is_velocity = kind in VELOCITIES
        self.unregistering = None
        self._starting = None if latch else _Starting()
        if latch:
            self._publisher = Publisher(name, self.cls, latch=True, queue_size=max(1, queue_size), tcp_nodelay=True)
        else:
            self._publisher = LatestPublisher(name, self.cls, self._starting)

    def publish(self, values):
        message = types.builder.build(self.cls, values)
        if self._starting is not None:
            self._starting.keep(message)
        self._publisher.publish(message)

    def unregister(self):
        self._publisher.unregister()


class Subscribed:
    """A topic that clients subscribe to: hands serialised messages over to the loop, of large ones only the newest."""

    def __init__(self, name, kind, loop):
        """``kind``: the type, '' for any."""
        self.kind, self.sessions = kind, set()
        self._name, self._loop = name, loop
        self._lock, self._waiting, self._latched = threading.Lock(), collections.deque(maxlen=BURST), {}
        self._subscriber = None

    def register(self):
        """Register it; messages come from now on."""
        self._subscriber = rospy.Subscriber(self._name, types.raw_class_of(self.kind), self._received, tcp_nodelay=True,
                                            buff_size=1 << 22)

    def _received(self, raw):
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
                self._waiting = collections.deque((one for one in self._waiting if len(one[0].data) <= SMALL), BURST)
            scheduled = bool(self._waiting)
            self._waiting.append((message, latched))
        if not scheduled:
            self._loop.call_soon_threadsafe(self._deliver)

    def _maker(self, header):
        """Return a function that makes a Message of the bytes from a connection with this header."""
        kind, definition = header.get('type', self.kind), header.get('message_definition', '')
        deserialise = functools.partial(types.deserialise, kind, definition)
        return lambda data: Message(self._name, data, deserialise, types.now())

    def _read_in_loop(self, make, header, connection, rest):
        """Read a connection in the loop until it ends; without a change of threads messages arrive sooner."""
        latched, ended = header.get('latching') == '1', threading.Event()

        def deliver(data):
            message = make(data)
            if latched:
                with self._lock:
                    self._latched[header.get('callerid')] = message
            for session in list(self.sessions):
                session.deliver(message, latched)
        self._loop.call_soon_threadsafe(functools.partial(Incoming, self._loop, connection, rest, deliver, ended.set))
        ended.wait()

    def _deliver(self):
        with self._lock:
            messages, self._waiting = self._waiting, collections.deque(maxlen=BURST)
        for message, latched in messages:
            for session in self.sessions:
                session.deliver(message, latched)

    def deliver_latched(self, session):
        """Send a later client the latched messages, as ROS does for a new subscriber."""
        with self._lock:
            latched = list(self._latched.values())
        for message in latched:
            session.deliver(message, True)

    def unregister(self):
        if self._subscriber is not None:
            self._subscriber.unregister()


class Topics:
    """The topics of all clients."""

    def __init__(self, loop, slow, unregister_timeout):
        """``slow(function, *arguments)``: a coroutine that runs a function elsewhere; ``unregister_timeout`` [s]."""
        self._loop, self._slow, self._timeout = loop, slow, unregister_timeout
        self._advertised, self._subscribed = {}, {}
        self._locks = collections.defaultdict(asyncio.Lock)

    def is_velocity(self, name):
        advertised = self._advertised.get(name)
        return advertised is not None and advertised.is_velocity

    def publish(self, session, name, values):
        """Publish; return a coroutine if the master must be asked for the type first."""
        advertised = self._advertised.get(name)
        if advertised is None:
            return self._publish_unadvertised(session, name, values)
        if session is not None:
            advertised.sessions.add(session)
        advertised.publish(values)
        return None

    async def _publish_unadvertised(self, session, name, values):
        kind = await self._slow(_type_of_slow, name)
        if not kind:
            raise Refused(f'the type of {name} is not known: nobody publishes it or subscribes to it. Advertise it '
                          'first: {"op": "advertise", "topic": "' + name + '", "type": "..."}')
        await self.advertise(session, name, kind, False, 100)
        self._advertised[name].publish(values)

    async def advertise(self, session, name, kind, latch, queue_size):
        async with self._locks[name]:
            advertised = self._advertised.get(name)
            if advertised is None:
                other = await self._slow(_type_of_slow, name)
                _compare(name, kind, other)
                advertised = await self._slow(_guarded, Advertised, name, kind, latch, queue_size)
                self._advertised[name] = advertised
            _compare(name, kind, advertised.kind)
            if advertised.unregistering is not None:
                advertised.unregistering.cancel()
                advertised.unregistering = None
            advertised.sessions.add(session)

    async def unadvertise(self, session, name):
        """End a client's publishing; the topic stays for a while, for clients that come again."""
        async with self._locks[name]:
            advertised = self._advertised.get(name)
            if advertised is None:
                return
            advertised.sessions.discard(session)
            if not advertised.sessions and advertised.unregistering is None:
                advertised.unregistering = self._loop.call_later(
                    self._timeout, lambda: self._loop.create_task(self._unregister(name, advertised)))

    async def _unregister(self, name, advertised):
        async with self._locks[name]:
            if not advertised.sessions and self._advertised.get(name) is advertised:
                del self._advertised[name]
                await self._slow(advertised.unregister)

    async def subscribe(self, session, name, kind):
        async with self._locks[name]:
            if kind:
                types.message_class(kind)
            subscribed = self._subscribed.get(name)
            if subscribed is None:
                other = await self._slow(_type_of_slow, name)
                _compare(name, kind, other)
                subscribed = Subscribed(name, kind or other, self._loop)
                subscribed.sessions.add(session)
                await self._slow(_guarded, subscribed.register)
                self._subscribed[name] = subscribed
                return
            _compare(name, kind, subscribed.kind)
            if session not in subscribed.sessions:
                subscribed.sessions.add(session)
                subscribed.deliver_latched(session)

    async def unsubscribe(self, session, name):
        async with self._locks[name]:
            subscribed = self._subscribed.get(name)
            if subscribed is not None:
                subscribed.sessions.discard(session)
                if not subscribed.sessions:
                    del self._subscribed[name]
                    await self._slow(subscribed.unregister)

    async def leave(self, session):
        for name in [name for name, one in self._advertised.items() if session in one.sessions]:
            await self.unadvertise(session, name)
        for name in [name for name, one in self._subscribed.items() if session in one.sessions]:
            await self.unsubscribe(session, name)


def _type_of_slow(name):
    if not rosgraph.names.is_legal_name(name):
        raise Refused(f'{name!r} is not a valid topic name: it may contain only letters, digits, _ and /')
    try:
        return rostopic.get_topic_type(name)[0] or ''
    except (rostopic.ROSTopicException, OSError) as error:
        raise Refused(f'the ROS master does not answer ({error}); start roscore') from None


def _guarded(function, *arguments):
    """Call a function that registers something; turn its errors into Refused."""
    try:
        return function(*arguments)
    except (rospy.ROSException, ValueError, OSError) as error:
        raise Refused(str(error)) from None


def _compare(name, kind, other):
    if kind and other and kind != other and other != '*':
        raise Refused(f'the type of {name} is {other}, not {kind}')
