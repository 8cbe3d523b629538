"""The clients of a server.

Threading contract: everything runs in the loop's thread.
"""
import asyncio
import collections
import socket
import time
from typing import Any, Awaitable, Callable, Dict, List, Optional, Set, Tuple, Type, Union

import tornado.httputil
import tornado.iostream
import tornado.routing

from browser_servers.core.connection import Connection, WebSocket
from browser_servers.core.session import Bridge, Session, Settings

CHECK_INTERVAL = 0.05  # [s] between two checks for silent and slow clients
SEND_BUFFER = 1 << 18  # [B] of the kernel for a client; its content cannot be overtaken
USER_TIMEOUT = 20000  # [ms] without an acknowledgement until the kernel closes a connection


class RosbridgeWebSocket(WebSocket):
    """One client, at any path."""

    def initialize(self, clients: 'Clients') -> None:
        self._clients, self.connected = clients, time.time()

    async def get(self, *arguments: Any, **keywords: Any) -> None:
        if len(self._clients) >= self._clients.max_clients:
            self.refuse(503, f'{self._clients.max_clients} clients are connected already; ~max_clients allows more')
            return
        await super().get(*arguments, **keywords)

    def opened(self, connection: Connection, stream: tornado.iostream.IOStream) -> None:
        stream.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
        stream.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, USER_TIMEOUT)
        clients = self._clients
        self._session = Session(clients.bridge, connection.send, connection.close, clients.settings, clients.warn)
        clients.add(self)

    def received(self, message: Union[str, bytes]) -> Optional[Awaitable[None]]:
        return self._session.received(message)

    def drain(self) -> None:
        self._session.drain()

    async def ended(self) -> None:
        self._clients.remove(self)
        await self._session.closed()

    def driving(self) -> Set[str]:
        return self._session.deadman.moving

    def check(self, now: float, stalled: float) -> None:
        self._session.check(now, stalled)


class _WebSockets(tornado.routing.Matcher):
    """Matches a request for a WebSocket, whatever its path: pages use several."""

    def match(self, request: tornado.httputil.HTTPServerRequest) -> Optional[Dict[str, Any]]:
        return {} if request.headers.get('Upgrade', '').lower() == 'websocket' else None


def websocket_rule(handler: Type[RosbridgeWebSocket], clients: 'Clients') -> tornado.routing.Rule:
    """Return the rule of an application that lets a handler serve WebSockets at every path."""
    return tornado.routing.Rule(_WebSockets(), handler, {'clients': clients})


class Clients:
    """All clients that are connected. ``changed`` gets [(address, time of the connection [s])] of all."""

    def __init__(self, bridge: Bridge, settings: Settings, max_clients: int, warn: Callable[[str], None],
                 changed: Callable[[List[Tuple[str, float]]], None]) -> None:
        """``max_clients`` may connect; ``warn`` logs their errors."""
        self.bridge, self.settings, self.max_clients, self.warn = bridge, settings, max_clients, warn
        self._clients: Set[RosbridgeWebSocket] = set()
        self._changed = changed
        asyncio.get_event_loop().create_task(self._watch())

    def __len__(self) -> int:
        return len(self._clients)

    def add(self, client: RosbridgeWebSocket) -> None:
        self._clients.add(client)
        self._report()

    def remove(self, client: RosbridgeWebSocket) -> None:
        self._clients.discard(client)
        self._report()

    def driving(self) -> Dict[str, int]:
        """Return {topic: number of clients that drive on it}."""
        return dict(collections.Counter(topic for client in self._clients for topic in client.driving()))

    def _report(self) -> None:
        self._changed([(client.request.remote_ip or '', client.connected) for client in self._clients])

    async def _watch(self) -> None:
        while True:
            due = time.monotonic() + CHECK_INTERVAL
            await asyncio.sleep(CHECK_INTERVAL)
            now = time.monotonic()
            for client in list(self._clients):
                client.check(now, now - due)
