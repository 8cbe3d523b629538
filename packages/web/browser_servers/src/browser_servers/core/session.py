"""One client: turns its frames into operations of ROS, and messages of ROS into frames for it.

Threading contract: everything runs in the thread of one asyncio loop. Operations that wait for ROS are coroutines of
the Bridge. A session does one operation after the other; velocities overtake waiting ones.
"""
import asyncio
import time
from typing import Any, Awaitable, Callable, Dict, List, NamedTuple, Optional, Protocol, Set, Tuple

from browser_servers.core.access import Rate
from browser_servers.core.deadman import Deadman
from browser_servers.core.encodings import Defragmenter, Frame, Message, fragments, from_png, to_cbor, to_json, to_png
from browser_servers.core.inbox import Inbox, is_zero
from browser_servers.core.operations import LEVELS, Operation, Refused, check, matches, parse
from browser_servers.core.outbox import Full, Outbox

SLICE = 0.001  # [s] of work before clients are read on: the zero velocity of one that floods comes last
BATCH = 65536  # [B] that are written before waiting for the client to take them
MAX_CALLS = 50  # unanswered service calls of a client
MAX_NAMES = 1000  # topics and services of a client
SLOW = 4000  # close code of a slow client


class Settings(NamedTuple):
    """The settings for all clients; times in seconds, sizes in bytes."""

    largest: int = 10_000_000
    fragment_timeout: float = 600.0
    deadman: float = 0.0
    rate: float = 20000.0
    burst: float = 40000.0
    slow: float = 10.0
    topics: Tuple[str, ...] = ()
    services: Tuple[str, ...] = ()


class Bridge(Protocol):
    """The access of sessions to ROS. Coroutines and ``publish`` raise Refused."""

    def is_velocity(self, topic: str) -> bool:
        """Return whether a topic is advertised here and carries velocities."""

    def publish(self, session: 'Session', topic: str, values: Any) -> Optional[Awaitable[None]]:
        """Publish a message; return None, or a coroutine that first asks the master for the type and then publishes."""

    def stop(self, topic: str) -> None:
        """Publish a zero velocity."""

    async def advertise(self, session: 'Session', topic: str, kind: str, latch: bool, queue_size: int) -> None:
        """Let a client publish."""

    async def unadvertise(self, session: 'Session', topic: str) -> None:
        """End a client's publishing on a topic."""

    async def subscribe(self, session: 'Session', topic: str, kind: Optional[str]) -> None:
        """Pass the messages of a topic to ``session.deliver``."""

    async def unsubscribe(self, session: 'Session', topic: str) -> None:
        """End the subscription."""

    async def call(self, service: str, arguments: Any, kind: Optional[str]) -> Dict[str, Any]:
        """Return the answer of a service."""

    async def advertise_service(self, session: 'Session', service: str, kind: str) -> None:
        """Pass the requests of a service to ``session.request``."""

    async def unadvertise_service(self, session: 'Session', service: str) -> None:
        """End the service."""

    def respond(self, session: 'Session', service: str, request: Any, values: Any, result: bool) -> None:
        """Answer a request."""

    async def leave(self, session: 'Session') -> None:
        """Forget a client."""


class Subscription(NamedTuple):
    """The settings of one subscribe operation."""

    period: float = 0.0
    length: int = 0
    fragment_size: Optional[int] = None
    compression: str = 'none'


class Session:
    """One client."""

    def __init__(self, bridge: Bridge, send: Callable[[Frame], 'asyncio.Future[None]'],
                 close: Callable[[int, str], None], settings: Settings,
                 warn: Callable[[str], None] = lambda text: None) -> None:
        """``send`` writes a frame; its future is done once the client has it; ``close`` takes a code and a reason."""
        self._bridge, self._send, self._close, self.settings, self._warn = bridge, send, close, settings, warn
        self._inbox, self._outbox = Inbox(), Outbox()
        self._parts = Defragmenter(settings.largest, settings.fragment_timeout)
        self._rate = Rate(settings.rate, settings.burst)
        self.deadman = Deadman(settings.deadman)
        self._level = LEVELS.index('error')
        self._subscriptions: Dict[str, Dict[Any, Subscription]] = {}
        self._loop = asyncio.get_event_loop()
        self._busy = self._draining = self._ended = False
        self._sending_since: Optional[float] = None
        self._timer: Optional[asyncio.TimerHandle] = None
        self._calls: Set[asyncio.Task[None]] = set()
        self._names: Set[Tuple[str, str]] = set()
        self._dropped = self._frames = 0
        self._space = asyncio.Event()

    # ------------------------------------------------------------------------------------------------ from the client

    def received(self, frame: Frame) -> Optional[Awaitable[None]]:
        """Queue a frame for ``drain``; return an awaitable to wait for before reading the next frame, or None."""
        self.deadman.heard(time.monotonic())
        pause = self._take(frame, 0)
        return self._wait(pause) if pause or self._inbox.full else None

    async def _wait(self, pause: float) -> None:
        if pause:
            await asyncio.sleep(pause)
        while self._inbox.full and not self._ended:
            self._space.clear()
            await self._space.wait()

    def _take(self, frame: Frame, depth: int) -> float:
        """Put the operation of a frame into the inbox; return how long [s] the client must wait."""
        operation: Operation = {}
        try:
            operation = parse(frame)
            name = check(operation)
            if name in ('fragment', 'png'):
                if depth > 1:
                    raise Refused(f'{name}: fragments and images may be nested at most twice')
                inner = self._parts.add(operation) if name == 'fragment' else \
                    from_png(operation['data'], self.settings.largest)
                return self._rate.pause() if inner is None else self._take(inner, depth + 1)
        except Refused as refused:
            self._inbox.put('refused', {'text': str(refused), 'id': operation.get('id')}, False)
            return self._rate.pause()
        if name != 'publish':
            self._inbox.put(name, operation, False, len(frame))
            return self._rate.pause()
        # a client that is not read could not stop its robot, so excess messages are dropped instead
        urgent = self._bridge.is_velocity(operation['topic'])
        if urgent or self._rate.admits():
            self._dropped += self._inbox.put(name, operation, urgent, len(frame))
        else:
            self._dropped += 1
        return 0.0

    def drain(self) -> None:
        """Do the waiting operations; call it after ``received``."""
        if not self._draining:
            self._drain()

    def _drain(self) -> None:
        self._draining = False
        end = time.monotonic() + SLICE
        while not self._ended:
            taken = self._inbox.take_velocity() if self._busy else self._inbox.take()
            if taken is None:
                break
            self._do(*taken)
            if time.monotonic() > end:
                self._draining = True
                self._loop.call_soon(self._drain)
                break
        if not self._inbox.full:
            self._space.set()

    def _do(self, name: str, operation: Operation) -> None:
        try:
            self._check_globs(name, operation)
            later = HANDLERS[name](self, operation)
        except Exception as error:
            self._refuse(name, operation, error)
            return
        if later is not None:
            self._busy = True
            self._keep(self._finish(name, operation, self._keep(later)))  # a task, as a client may leave at once

    async def _finish(self, name: str, operation: Operation, later: Awaitable[None]) -> None:
        try:
            await later
        except Exception as error:
            self._refuse(name, operation, error)
        finally:
            self._busy = False
            self.drain()

    def _keep(self, coroutine: Any) -> 'asyncio.Task[None]':
        task = self._loop.create_task(coroutine)
        self._calls.add(task)
        task.add_done_callback(self._calls.discard)
        return task

    def _refuse(self, name: str, operation: Operation, error: Exception) -> None:
        text = str(error) if isinstance(error, Refused) else f'{type(error).__name__}: {error}'
        text_with_name = text if text.startswith(name) else f'{name}: {text}'
        if name == 'call_service':  # no status beside the answer: roslibpy takes one for an error of its own
            self._warn(text_with_name)
            self._answer_call(operation, text, False)
        else:
            self.status('error', text_with_name, operation.get('id'))

    def _check_globs(self, name: str, operation: Operation) -> None:
        for field, globs in (('topic', self.settings.topics), ('service', self.settings.services)):
            if field in operation and not matches(operation[field], list(globs)):
                raise Refused(f'{name}: the {field} {operation[field]} is not among those that this server allows '
                              f'(~{field}s_glob): {", ".join(globs)}')

    # ------------------------------------------------------------------------------------------------ operations

    def _count(self, kind: str, name: str) -> None:
        self._names.add((kind, name))
        if len(self._names) > MAX_NAMES:
            self._names.discard((kind, name))
            raise Refused(f'a client may use at most {MAX_NAMES} topics and services')

    def _advertise(self, operation: Operation) -> Awaitable[None]:
        topic = operation['topic']
        self._count('advertise', topic)
        return self._bridge.advertise(self, topic, operation['type'], operation.get('latch', False),
                                      operation.get('queue_size', 100))

    def _unadvertise(self, operation: Operation) -> Awaitable[None]:
        self._names.discard(('advertise', operation['topic']))
        return self._bridge.unadvertise(self, operation['topic'])

    def _publish(self, operation: Operation) -> Optional[Awaitable[None]]:
        topic, values = operation['topic'], operation.get('msg', {})
        self._count('advertise', topic)
        later = self._bridge.publish(self, topic, values)
        if self._bridge.is_velocity(topic):
            self.deadman.drove(topic, is_zero(values))
        return later

    def _subscribe(self, operation: Operation) -> Awaitable[None]:
        topic, kind = operation['topic'], operation.get('type')
        self._count('subscribe', topic)
        self._subscriptions.setdefault(topic, {})[operation.get('id')] = Subscription(
            operation.get('throttle_rate', 0) / 1000, operation.get('queue_length', 0), operation.get('fragment_size'),
            operation.get('compression', 'none'))
        self._configure(topic)
        return self._subscribed(topic, kind)

    async def _subscribed(self, topic: str, kind: Optional[str]) -> None:
        try:
            await self._bridge.subscribe(self, topic, kind)
        except Exception:
            self._forget(topic)
            raise
        self.status('info', f'Subscribed to {topic}')

    def _unsubscribe(self, operation: Operation) -> Optional[Awaitable[None]]:
        topic, name = operation['topic'], operation.get('id')
        if topic not in self._subscriptions:
            return None
        if name is not None:
            self._subscriptions[topic].pop(name, None)
            if self._subscriptions[topic]:
                self._configure(topic)
                return None
        self._forget(topic)
        return self._bridge.unsubscribe(self, topic)

    def _forget(self, topic: str) -> None:
        self._subscriptions.pop(topic, None)
        self._names.discard(('subscribe', topic))
        self._outbox.forget(topic)

    def _configure(self, topic: str) -> None:
        subscriptions = self._subscriptions[topic].values()
        self._outbox.configure(topic, min(subscription.period for subscription in subscriptions),
                               max(subscription.length for subscription in subscriptions))

    def _call_service(self, operation: Operation) -> None:
        if len(self._calls) >= MAX_CALLS:
            raise Refused(f'{MAX_CALLS} service calls are still unanswered; this one is not made')
        self._keep(self._called(operation))

    async def _called(self, operation: Operation) -> None:
        try:
            values = await self._bridge.call(operation['service'].partition('#')[0], operation.get('args') or {},
                                             operation.get('type'))
        except Exception as error:
            self._refuse('call_service', operation, error)
            return
        self._answer_call(operation, values, True)

    def _answer_call(self, operation: Operation, values: Any, result: bool) -> None:
        answer = {'op': 'service_response', 'service': operation['service'], 'values': values, 'result': result}
        if operation.get('id') is not None:
            answer['id'] = operation['id']
        self.answer(answer, operation.get('fragment_size'), operation.get('compression', 'none'))

    def _advertise_service(self, operation: Operation) -> Awaitable[None]:
        self._count('service', operation['service'])
        return self._bridge.advertise_service(self, operation['service'], operation['type'])

    def _unadvertise_service(self, operation: Operation) -> Awaitable[None]:
        self._names.discard(('service', operation['service']))
        return self._bridge.unadvertise_service(self, operation['service'])

    def _service_response(self, operation: Operation) -> None:
        self._bridge.respond(self, operation['service'], operation.get('id'), operation.get('values'),
                             operation['result'])

    def _set_level(self, operation: Operation) -> None:
        self._level = LEVELS.index(operation['level']) if operation['level'] != 'none' else -1

    def _refused(self, operation: Operation) -> None:
        """Report the fault of a frame, in its turn."""
        self.status('error', operation['text'], operation['id'])

    def _status(self, operation: Operation) -> None:
        """Ignore it: the client's own log."""

    def _auth(self, operation: Operation) -> None:
        raise Refused('"auth" is not supported: clients on this machine need no permission, others a token in the '
                      'address: ws://robot:9090/?token=...')

    def _deadman(self, operation: Operation) -> None:
        self.deadman.timeout = operation['timeout']

    # ------------------------------------------------------------------------------------------------ to the client

    def status(self, level: str, text: str, name: Any = None) -> None:
        """Send a status if the client wants this level; the server logs errors as warnings, too."""
        if level == 'error':
            self._warn(text)
        if LEVELS.index(level) <= self._level:
            self.answer({'op': 'status', 'level': level, 'msg': text, **({} if name is None else {'id': name})})

    def request(self, service: str, request: str, arguments: Dict[str, Any]) -> None:
        """Send the client a request of a service that it has advertised."""
        self.answer({'op': 'call_service', 'id': request, 'service': service, 'args': arguments})

    def answer(self, operation: Operation, fragment_size: Optional[int] = None, compression: str = 'none') -> None:
        """Send an operation other than a topic's message."""
        frame: Frame
        if compression in ('cbor', 'cbor-raw'):
            frame = to_cbor(operation)
        else:
            frame = to_json(operation)
            if compression == 'png':
                frame = to_json({'op': 'png', 'data': to_png(frame)})
        try:
            self._outbox.answer((frame, fragment_size, operation.get('id')), len(frame))
        except Full:
            self.end(SLOW, 'it does not read its answers')
            return
        self.pump()

    def deliver(self, message: Message, kept: bool = False) -> None:
        """Send a message of a topic that the client has subscribed to."""
        self._outbox.put(message.topic, message, len(message.data), time.monotonic(), kept)
        self.pump()

    def pump(self) -> None:
        """Write waiting data, as far as the client takes them."""
        if self._sending_since is not None or self._ended:
            return
        now, written = time.monotonic(), 0
        while True:
            item = self._outbox.take(now)
            if item is None:
                break
            for frame in self._encoded(item):
                written += len(frame)
                done = self._send(frame)
                if not done.done() or written > BATCH:
                    self._sending_since = now
            if self._sending_since is not None:
                done.add_done_callback(self._sent)
                return
        due = self._outbox.next_due()
        if due is not None:
            if self._timer is not None:
                self._timer.cancel()
            self._timer = self._loop.call_later(max(0.0, due - now), self.pump)

    def _sent(self, done: 'asyncio.Future[None]') -> None:
        self._sending_since = None
        if not done.cancelled() and done.exception() is None:
            self.pump()  # otherwise the client has disconnected; ``closed`` follows

    def _encoded(self, item: Any) -> List[Frame]:
        self._frames += 1
        if not isinstance(item, Message):
            frame, size, name = item
            return list(fragments(frame, size, f'answer_{self._frames}' if name is None else name))
        subscriptions = self._subscriptions.get(item.topic, {}).values()
        if not subscriptions:
            return []
        requested = {subscription.compression for subscription in subscriptions}
        compression = next(name for name in ('cbor-raw', 'cbor', 'png', 'none') if name in requested)
        try:
            frame = item.frame(compression)
        except Exception as error:  # the publisher's fault
            self.status('error', f'subscribe: a message of {item.topic} cannot be read: {error}')
            return []
        size = min((subscription.fragment_size for subscription in subscriptions
                    if subscription.fragment_size is not None), default=None)
        return list(fragments(frame, size, f'{item.topic}_{self._frames}'))

    # ------------------------------------------------------------------------------------------------ the end

    def check(self, now: float, stalled: float = 0.0) -> None:
        """Stop what a silent client drives, disconnect a slow one, report drops; call it many times a second.

        ``stalled`` [s]: for how long this server did nothing before, in which a client could not be served.
        """
        if self.deadman.watching:
            self._stop(self.deadman.expired(now), f'silent for {self.deadman.timeout:g} s')
        if self._dropped:
            self.status('error', f'publish: {self._dropped} messages came faster than this server works and were '
                        'dropped; velocities never are')
            self._dropped = 0
        if self._sending_since is not None:
            self._sending_since += stalled
            if now - self._sending_since > self.settings.slow:
                self.end(SLOW, f'it has not taken a message for {self.settings.slow:g} s')

    def _stop(self, topics: List[str], why: str) -> None:
        for topic in topics:
            self._warn(f'The client that drove {topic} is {why}: it is stopped.')
            self._bridge.stop(topic)

    def end(self, code: int, reason: str) -> None:
        if not self._ended:
            self._warn(f'A client is disconnected: {reason}.')
            self._close(code, reason)

    def closed(self) -> Awaitable[None]:
        """Note that the connection is closed; return an awaitable that frees everything."""
        self._ended = True
        self._space.set()
        self._stop(self.deadman.gone(), 'gone')
        if self._timer is not None:
            self._timer.cancel()
        for task in self._calls:
            task.cancel()
        return self._bridge.leave(self)


HANDLERS: Dict[str, Callable[[Session, Operation], Optional[Awaitable[None]]]] = {
    'advertise': Session._advertise, 'unadvertise': Session._unadvertise, 'publish': Session._publish,
    'subscribe': Session._subscribe, 'unsubscribe': Session._unsubscribe, 'call_service': Session._call_service,
    'advertise_service': Session._advertise_service, 'unadvertise_service': Session._unadvertise_service,
    'service_response': Session._service_response, 'set_level': Session._set_level, 'status': Session._status,
    'auth': Session._auth, 'deadman': Session._deadman,
    'refused': Session._refused}  # of OPERATIONS, all but those that hold another one; and the report of a fault
