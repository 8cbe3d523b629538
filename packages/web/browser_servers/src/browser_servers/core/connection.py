"""The WebSocket of one client: tornado's, which also tells a client that breaks the rules why it is disconnected.

``_abort`` is a private method of tornado's WebSocketProtocol13, the same in versions 6.1 to 6.5; test_connection.py
holds it. Tornado's own pings are not used: 6.5 gives a client no more time to answer than the interval.

Threading contract: everything runs in the thread of one asyncio loop.
"""
import asyncio
import contextlib
import zlib
from typing import Any, Awaitable, Callable, Dict, Optional, Union

import tornado.iostream
from tornado.websocket import WebSocketClosedError, WebSocketHandler, WebSocketProtocol, WebSocketProtocol13

from browser_servers.core.web import Guarded

CHUNK = 65536  # [B] that are read before other clients get their turn
READ_ON = 5.0  # [s] in which a client that breaks the rules is read, and what it sends dropped, so that it learns why
CLOSING = 1.0  # [s] in which a client must take its close frame
PROTOCOL, TOO_BIG = 1002, 1009  # close codes
CODES = {*range(1000, 1015), *range(3000, 5000)} - {1004, 1005, 1006}  # that a close frame may have
BROKEN = 'a frame or a text breaks the rules of WebSockets (RFC 6455): its length, opcode, bits, compression or UTF-8'
Received = Callable[[Union[str, bytes]], Optional[Awaitable[None]]]


class _Protocol(WebSocketProtocol13):
    """Sends a close frame instead of closing the connection at once."""

    patience = CLOSING

    def close(self, code: Optional[int] = None, reason: Optional[str] = None) -> None:
        """Close the connection with a code and a reason of at most 123 bytes."""
        if code == TOO_BIG:
            self.patience = READ_ON
            reason = f'a message may have {self.params.max_message_size} bytes; ~max_message_size allows more'
        elif code is not None and code not in CODES:  # tornado would echo it
            code, reason = PROTOCOL, BROKEN
        super().close(code, reason)

    def _abort(self) -> None:
        if not self.server_terminated:
            self.patience = READ_ON
            self.close(PROTOCOL, BROKEN)
        self.client_terminated = True


class Connection:
    """The part of a WebSocket that a session uses."""

    def __init__(self, handler: 'WebSocket', stream: tornado.iostream.IOStream) -> None:
        self._handler, self._stream = handler, stream
        self._loop = asyncio.get_event_loop()
        self._done = self._loop.create_future()
        self._done.set_result(None)

    def send(self, message: Union[str, bytes]) -> 'asyncio.Future[None]':
        """Write a message; the future is done once the client's socket has it."""
        try:
            written = self._handler.write_message(message, isinstance(message, bytes))
        except WebSocketClosedError:
            return self._loop.create_future()
        if not self._stream.writing():
            return self._done
        written.add_done_callback(lambda done: done.cancelled() or done.exception())
        return written

    def close(self, code: int, reason: str) -> None:
        """Close the connection, after CLOSING even if the client does not read."""
        self._handler.close(code, reason[:100])
        self._loop.call_later(CLOSING, self._stream.close)


class WebSocket(Guarded, WebSocketHandler):
    """Accepts a WebSocket; subclasses have ``opened``, ``received``, ``drain`` and ``ended``.

    The application's settings have ``websocket_max_message_size`` [B], ``ping_interval`` [s], ``ping_timeout`` [s] and
    ``use_compression``.
    """

    async def get(self, *arguments: Any, **keywords: Any) -> None:
        """Accept a client, or say why not; return when it has gone."""
        self._stream: Optional[tornado.iostream.IOStream] = None
        self._loop = asyncio.get_event_loop()
        self._heard, self._unyielded = self._loop.time(), 0
        self._draining: Optional[asyncio.Handle] = None
        self._pings: Optional[asyncio.Future[None]] = None
        try:
            await super().get(*arguments, **keywords)
        except zlib.error:  # tornado expects only a compressed message that is too large
            self._protocol._abort()
        finally:
            if self._stream is not None:
                await self._end(self._stream)

    def check_origin(self, origin: str) -> bool:
        """Accept all origins: Guarded has refused foreign ones."""
        return True

    def get_compression_options(self) -> Optional[Dict[str, Any]]:
        return {} if self.settings['use_compression'] else None

    def get_websocket_protocol(self) -> Optional[WebSocketProtocol]:
        """Return a protocol that says why it ends."""
        protocol = super().get_websocket_protocol()
        if not isinstance(protocol, WebSocketProtocol13):
            return protocol
        self._protocol = _Protocol(self, False, protocol.params)
        return self._protocol

    def detach(self) -> tornado.iostream.IOStream:
        self._stream = stream = super().detach()
        stream.max_buffer_size = max(stream.max_buffer_size, 2 * self.max_message_size)
        stream.set_nodelay(True)
        return stream

    def open(self, *_: Any, **__: Any) -> None:
        assert self._stream is not None
        if self.settings['ping_interval']:
            self._pings = asyncio.ensure_future(self._ping(self._stream))
        self.opened(Connection(self, self._stream), self._stream)

    def on_message(self, message: Union[str, bytes]) -> Optional[Awaitable[None]]:
        """Hand a message over; ``drain`` follows once those that have come are read."""
        if self._protocol.server_terminated:
            return None
        self._heard = self._loop.time()
        wait = self.received(message)
        if self._draining is None:
            self._draining = self._loop.call_soon(self._drain)
        self._unyielded += len(message)
        if wait is None and self._unyielded > CHUNK:
            wait = asyncio.sleep(0)  # what the stream holds already would be read before anything else
        if wait is not None:
            self._unyielded = 0
        return wait

    def _drain(self) -> None:
        self._draining = None
        self.drain()

    def on_pong(self, data: bytes) -> None:
        self._heard = self._loop.time()

    async def _ping(self, stream: tornado.iostream.IOStream) -> None:
        interval, timeout = self.settings['ping_interval'], self.settings['ping_timeout']
        with contextlib.suppress(WebSocketClosedError):
            while True:
                due = self._loop.time() + interval
                await asyncio.sleep(interval)
                self._heard += self._loop.time() - due  # in that time this server could not listen itself
                if self._loop.time() - self._heard > max(interval, timeout):
                    stream.close()
                    return
                self.ping()

    async def _end(self, stream: tornado.iostream.IOStream) -> None:
        """Close the connection once the client has closed it, or after a while.

        What it sends is dropped; a socket that is closed with unread data takes back what was sent.
        """
        if self._pings is not None:
            self._pings.cancel()
        if self._draining is not None:
            self._draining.cancel()
            self.drain()
        await self.ended()
        closing = self._loop.call_later(self._protocol.patience, stream.close)
        with contextlib.suppress(tornado.iostream.StreamClosedError):
            while True:
                await stream.read_bytes(CHUNK, partial=True)
        closing.cancel()

    def opened(self, connection: Connection, stream: tornado.iostream.IOStream) -> None:
        """Begin to use the connection."""
        raise NotImplementedError

    def received(self, message: Union[str, bytes]) -> Optional[Awaitable[None]]:
        """Take a message; return what has to be awaited before the next one is read, or None."""
        raise NotImplementedError

    def drain(self) -> None:
        """Do what was received."""
        raise NotImplementedError

    async def ended(self) -> None:
        """Note that the client has left, or that nothing more is read from it."""
        raise NotImplementedError
