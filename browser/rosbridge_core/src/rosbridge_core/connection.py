"""The WebSocket of one client on a tornado stream: its handshake, its messages, pings, and its end.

Tornado's own WebSocket reads a frame in four steps, each a turn of the loop, and writes it by a task; that took half of
the time of a small message. This one reads what has come at once, and writes at once.

Threading contract: everything runs in the thread of one asyncio loop.
"""
import asyncio
import contextlib
from typing import Any, Awaitable, Callable, Optional, Union

import tornado.iostream

from rosbridge_core import frames
from rosbridge_core.frames import Broken, Reader, frame
from rosbridge_core.web import Guarded

CHUNK = 65536  # [B] that are read before other clients get their turn
READ_ON = 5.0  # [s] in which a client that breaks the rules is read, and what it sends dropped, so that it learns why
CLOSING = 1.0  # [s] in which a client has to take its close frame
DEFLATE = 'permessage-deflate'


class Connection:
    """A WebSocket after its handshake."""

    def __init__(self, stream: tornado.iostream.IOStream, largest: int, deflate: bool) -> None:
        """``largest`` [B] of a client's message; ``deflate``: both compress."""
        self._stream, self._deflate = stream, deflate
        self._reader = Reader(largest, deflate)
        self._loop = asyncio.get_event_loop()
        self._closing = False
        self._heard = self._loop.time()

    async def read(self, received: Callable[[Union[str, bytes]], Optional[Awaitable[None]]],
                   rest: Callable[[], None]) -> None:
        """Read until the end. ``received`` gets each message, and returns what to await; ``rest`` follows a chunk."""
        with contextlib.suppress(tornado.iostream.StreamClosedError):
            while not self._closing:
                data = await self._stream.read_bytes(CHUNK, partial=True)
                self._heard = self._loop.time()
                wait = None
                try:
                    for opcode, message in self._reader.feed(data):
                        if opcode in (frames.TEXT, frames.BINARY):
                            wait = received(message) or wait
                        elif isinstance(message, bytes):
                            self._control(opcode, message)
                except Broken as broken:
                    rest()
                    await self._read_on(broken)
                    return
                rest()
                if wait is not None:
                    await wait
                elif len(data) == CHUNK:
                    await asyncio.sleep(0)  # what the stream holds already would be read before anything else

    def _control(self, opcode: int, payload: bytes) -> None:
        if opcode == frames.PING:
            self._stream.write(frame(frames.PONG, payload))
        elif opcode == frames.CLOSE:
            self.close(int.from_bytes(payload[:2], 'big') if len(payload) >= 2 else 1000, '')

    async def _read_on(self, broken: Broken) -> None:
        """Say why, drop what comes, and close; a socket that is closed with unread data takes back what was sent."""
        self.close(broken.code, broken.reason, READ_ON)
        while True:
            await self._stream.read_bytes(CHUNK, partial=True)

    def send(self, message: Union[str, bytes]) -> 'asyncio.Future[None]':
        """Write a message; the future is done once the client's socket has it."""
        try:
            if isinstance(message, bytes):
                return self._stream.write(frame(frames.BINARY, message, self._deflate))
            return self._stream.write(frame(frames.TEXT, message.encode(), self._deflate))
        except tornado.iostream.StreamClosedError:
            return self._loop.create_future()

    def close(self, code: int, reason: str, patience: float = CLOSING) -> None:
        """Close the connection, after ``patience`` [s] even if the client does not read."""
        if self._closing:
            return
        self._closing = True
        with contextlib.suppress(tornado.iostream.StreamClosedError):
            written = self._stream.write(frame(frames.CLOSE, code.to_bytes(2, 'big') + reason.encode()[:100]))
            self._loop.call_later(patience, self._stream.close)
            if not reason:
                written.add_done_callback(lambda _: self._stream.close())

    async def ping(self, interval: float, timeout: float) -> None:
        """Ask every ``interval`` [s] whether the client is there; close the connection after ``timeout`` [s]."""
        while not self._stream.closed():
            await asyncio.sleep(interval)
            if self._loop.time() - self._heard > max(interval, timeout):
                self._stream.close()
                return
            with contextlib.suppress(tornado.iostream.StreamClosedError):
                self._stream.write(frame(frames.PING, b''))


class WebSocket(Guarded):
    """Accepts a WebSocket; subclasses have ``opened``.

    The application's settings have ``websocket_max_message_size`` [B], ``websocket_ping_interval`` [s],
    ``websocket_ping_timeout`` [s] and ``use_compression``.
    """

    async def get(self, *_: Any) -> None:
        """Accept a client, or say why not; return when it has gone."""
        if self._finished:
            return
        headers = self.request.headers
        key = headers.get('Sec-WebSocket-Key')
        if not key or 'upgrade' not in headers.get('Connection', '').lower():
            self.refuse(400, 'this is not a WebSocket handshake: Connection: Upgrade or Sec-WebSocket-Key is missing')
            return
        if headers.get('Sec-WebSocket-Version') not in ('7', '8', '13'):
            self.refuse(426, 'the WebSocket must have version 13')
            return
        deflate = bool(self.settings['use_compression']) and DEFLATE in headers.get('Sec-WebSocket-Extensions', '')
        self.clear()
        self.set_status(101)
        self.set_header('Upgrade', 'websocket')
        self.set_header('Connection', 'Upgrade')
        self.set_header('Sec-WebSocket-Accept', frames.accept_key(key))
        if deflate:
            self.set_header('Sec-WebSocket-Extensions',
                            f'{DEFLATE}; server_no_context_takeover; client_no_context_takeover')
        self.finish()
        stream = self.detach()
        stream.set_nodelay(True)
        connection = Connection(stream, self.settings['websocket_max_message_size'], deflate)
        interval = self.settings['websocket_ping_interval']
        pings = asyncio.ensure_future(connection.ping(interval, self.settings['websocket_ping_timeout'])) \
            if interval else None
        try:
            await self.opened(connection, stream)
        finally:
            if pings is not None:
                pings.cancel()
            if not stream.closed():
                await self._closed(stream)

    @staticmethod
    async def _closed(stream: tornado.iostream.IOStream) -> None:
        """Drop what comes until the connection is closed, by the client or by ``close``."""
        with contextlib.suppress(tornado.iostream.StreamClosedError):
            while True:
                await stream.read_bytes(CHUNK, partial=True)

    async def opened(self, connection: Connection, stream: tornado.iostream.IOStream) -> None:
        """Use the connection until it ends."""
        raise NotImplementedError
