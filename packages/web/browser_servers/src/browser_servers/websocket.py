"""The clients of a server.

Threading contract: everything runs in the loop's thread.
"""
import asyncio
import collections
import socket
import time

import tornado.routing

from browser_servers.core.connection import WebSocket
from browser_servers.core.session import Session

CHECK_INTERVAL = 0.05  # [s] between two checks for silent and slow clients
SEND_BUFFER = 1 << 18  # [B] of the kernel for a client; its content cannot be overtaken
USER_TIMEOUT = 20000  # [ms] without an acknowledgement until the kernel closes a connection


class RosbridgeWebSocket(WebSocket):
    """One client, at any path."""

    def initialize(self, clients):
        """``clients``: the Clients."""
        self._clients, self._session, self.connected = clients, None, time.time()

    async def get(self, *arguments, **keywords):
        if len(self._clients) >= self._clients.most:
            self.refuse(503, f'{self._clients.most} clients are connected already; ~max_clients allows more')
            return
        await super().get(*arguments, **keywords)

    def opened(self, connection, stream):
        stream.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
        stream.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, USER_TIMEOUT)
        clients = self._clients
        self._session = session = Session(clients.bridge, connection.send, connection.close, clients.settings,
                                          clients.warn)
        self.received, self.drain = session.received, session.drain
        clients.add(self)

    async def ended(self):
        self._clients.remove(self)
        await self._session.closed()

    def driving(self):
        return self._session.deadman.moving

    def check(self, now, stalled):
        self._session.check(now, stalled)


class _WebSockets(tornado.routing.Matcher):
    """Matches a request for a WebSocket, whatever its path: pages use several."""

    def match(self, request):
        return {} if request.headers.get('Upgrade', '').lower() == 'websocket' else None


def websocket_rule(handler, clients):
    """Return the rule of an application that lets a handler serve WebSockets at every path."""
    return tornado.routing.Rule(_WebSockets(), handler, {'clients': clients})


class Clients:
    """All clients that are connected. ``changed`` gets [(address, time of the connection [s])] of all."""

    def __init__(self, bridge, settings, most, warn, changed):
        """``most``: how many clients may connect; ``warn`` logs their errors."""
        self.bridge, self.settings, self.most, self.warn = bridge, settings, most, warn
        self._clients, self._changed = set(), changed
        asyncio.get_event_loop().create_task(self._watch())

    def __len__(self):
        return len(self._clients)

    def add(self, client):
        self._clients.add(client)
        self._tell()

    def remove(self, client):
        self._clients.discard(client)
        self._tell()

    def driving(self):
        """Return {topic: number of clients that drive on it}."""
        return dict(collections.Counter(topic for client in self._clients for topic in client.driving()))

    def _tell(self):
        self._changed([(client.request.remote_ip, client.connected) for client in self._clients])

    async def _watch(self):
        while True:
            due = time.monotonic() + CHECK_INTERVAL
            await asyncio.sleep(CHECK_INTERVAL)
            now = time.monotonic()
            for client in list(self._clients):
                client.check(now, now - due)
