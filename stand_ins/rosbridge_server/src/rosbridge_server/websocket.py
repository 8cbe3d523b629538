"""The websocket of a client.

Threading contract: everything runs in the loop's thread.
"""
import asyncio
import contextlib
import socket
import time

import tornado.iostream
import tornado.websocket

from rosbridge_core.session import Session
from rosbridge_core.web import Guarded

READ_ON = 5.0  # [s] in which a client that sends too much is read, and what it sends dropped
CHUNK = 1 << 20  # [B]
LOOK = 0.05  # [s] between two looks at silent and slow clients
USER_TIMEOUT = 20000  # [ms] without an acknowledgement of what was sent, after which the kernel closes a connection


class _Protocol(tornado.websocket.WebSocketProtocol13):
    """Tornado's protocol, but a client that sends too much can read why before its connection is closed."""

    _reads_on = False

    def _abort(self):
        if self.server_terminated and not self.client_terminated:
            self.client_terminated = self._reads_on = True  # no more frames are read
            asyncio.ensure_future(_read_on(self.stream))
        elif not self._reads_on:
            super()._abort()


async def _read_on(stream):
    """Drop what comes, and close; a socket that is closed with unread data takes back what was sent."""
    end = time.monotonic() + READ_ON
    with contextlib.suppress(tornado.iostream.StreamClosedError, asyncio.TimeoutError):
        while True:
            await asyncio.wait_for(stream.read_bytes(CHUNK, partial=True), end - time.monotonic())
    stream.close()


class RosbridgeWebSocket(Guarded, tornado.websocket.WebSocketHandler):
    """One client; it connects where the path is / and anything else that no page has."""

    def initialize(self, clients):
        """``clients``: the Clients."""
        self._clients, self._session, self.connected = clients, None, time.time()

    async def get(self, *arguments, **keywords):
        """Accept a client, or say why not."""
        if self._finished:
            return
        if len(self._clients) >= self._clients.most:
            self.refuse(503, f'{self._clients.most} clients are connected already; ~max_clients allows more')
            return
        await super().get(*arguments, **keywords)

    def check_origin(self, origin):
        """Leave it to Guarded."""
        return True

    def get_websocket_protocol(self):
        """Be tornado's hook."""
        protocol = super().get_websocket_protocol()
        if protocol is not None:
            protocol.__class__ = _Protocol
        return protocol

    def get_compression_options(self):
        """Compress where the parameter says so."""
        return {} if self.settings['use_compression'] else None

    def open(self, *_):
        """Be tornado's callback."""
        self.set_nodelay(True)
        stream = self.ws_connection.stream
        stream.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, USER_TIMEOUT)
        clients = self._clients
        self._session = Session(clients.bridge, self._write, self._end, clients.settings, clients.warn)
        self._clients.add(self)

    def on_message(self, message):
        """Be tornado's callback."""
        return self._session.received(message)

    def _write(self, frame):
        try:
            written = self.write_message(frame, isinstance(frame, bytes))
            written.add_done_callback(_note_error)
            return written
        except tornado.websocket.WebSocketClosedError:
            return asyncio.get_event_loop().create_future()

    def _end(self, code, reason):
        self.close(code, reason[:100])
        connection = self.ws_connection
        if connection is not None:  # a client that does not read does not answer the close frame either
            asyncio.get_event_loop().call_later(1.0, connection.stream.close)

    def on_close(self):
        """Be tornado's callback."""
        if self._session is not None:
            self._clients.remove(self)
            asyncio.ensure_future(self._session.closed())

    def look(self, now):
        """Look at a silent or slow client."""
        self._session.look(now)


def _note_error(written):
    """Let asyncio not log that a client went while it was written to: on_close tells it."""
    if not written.cancelled():
        written.exception()


class Clients:
    """All clients that are connected. ``changed`` is called with {client: (address, time of its connection [s])}."""

    def __init__(self, bridge, settings, most, warn, changed):
        """``most``: how many may connect; ``warn`` logs what a client did wrong."""
        self.bridge, self.settings, self.most, self.warn = bridge, settings, most, warn
        self._clients, self._changed = set(), changed
        asyncio.get_event_loop().create_task(self._watch())

    def __len__(self):
        return len(self._clients)

    def add(self, client):
        """Add one."""
        self._clients.add(client)
        self._tell()

    def remove(self, client):
        """Remove one."""
        self._clients.discard(client)
        self._tell()

    def _tell(self):
        self._changed([(client.request.remote_ip, client.connected) for client in self._clients])

    async def _watch(self):
        while True:
            await asyncio.sleep(LOOK)
            now = time.monotonic()
            for client in list(self._clients):
                client.look(now)
