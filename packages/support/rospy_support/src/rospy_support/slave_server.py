"""A node's XML-RPC server (the slave API of ROS); a SocketWatch reads its requests.

The fault: rosgraph's server starts a thread for each connection, 353 of them beside 2,000 idle connections, and reads a
body of any length: one of 50 MB takes 324 MB of memory.
"""
import contextlib
import io
import threading
from socket import socket as Socket
from typing import Any

import rosgraph.xmlrpc

from rospy_support.inbound import Ended, Refused, SocketWatch, read_http

BODY_LIMIT = 4 << 20  # [bytes] of a request; the longest ones of ROS hold a list of publishers, or a parameter
DEADLINE = 60.0  # [s] for each request of a connection; the master keeps its connections open
REFUSAL = b'HTTP/1.1 413 Payload Too Large\r\nContent-Length: 0\r\nConnection: close\r\n\r\n'


class SlaveServer(rosgraph.xmlrpc.ThreadingXMLRPCServer):
    """Starts a thread for each complete request.

    ``allows(method, connection)`` decides whether a call is made; every one is, unless a process replaces it.
    """

    @staticmethod
    def allows(_method: str, _connection: Socket) -> bool:
        """Return True."""
        return True

    def __init__(self, watch: SocketWatch, address: Any, log_requests: int = 1) -> None:
        self._watch, self._closed = watch, threading.Event()
        super().__init__(address, log_requests)

    def serve_forever(self, poll_interval: float = 0.5) -> None:
        """Let the watch accept connections until the server is closed."""
        self._watch.listen(self.socket, self._serve)
        self._closed.wait()

    def server_close(self) -> None:
        """Close the listening socket."""
        self._closed.set()
        self._watch.close(self.socket)

    async def _serve(self, connection: Socket, address: Any) -> None:
        """Read a request, and let a thread answer it."""
        try:
            request = await self._watch.read(read_http(connection, BODY_LIMIT), DEADLINE)
        except Ended:
            connection.close()
        except Refused as error:
            self._watch.report('refused', f'Closed a connection of {address[0]} to the XML-RPC server: {error}.')
            with contextlib.suppress(OSError):
                connection.send(REFUSAL)
            connection.close()
        else:
            threading.Thread(target=self._answer, args=(connection, address, request), daemon=True).start()

    def _answer(self, connection: Socket, address: Any, request: bytes) -> None:
        try:
            connection.setblocking(True)
            keep = not _RequestHandler(connection, address, self, request).close_connection
        except Exception:  # the peer has gone, or does not send HTTP; written to the log file, as in rosgraph
            self.handle_error(connection, address)
            keep = False
        if keep:
            connection.setblocking(False)
            self._watch.run(self._serve(connection, address))
        else:
            connection.close()


class _RequestHandler(rosgraph.xmlrpc.SilenceableXMLRPCRequestHandler):
    """Answers one request, which has already been read."""

    def __init__(self, connection: Socket, address: Any, server: SlaveServer, request: bytes) -> None:
        self._request = request
        super().__init__(connection, address, server)

    def setup(self) -> None:
        super().setup()
        self.rfile.close()
        self.rfile: io.BufferedIOBase = io.BytesIO(self._request)

    def handle(self) -> None:
        self.close_connection = True
        self.handle_one_request()

    def _dispatch(self, method: str, params: Any) -> Any:
        """Answer a call, or refuse it as an error of the slave API; xmlrpc.server asks its handler first."""
        if not self.server.allows(method, self.connection):
            return -1, f'{method} is refused', 0
        return self.server._dispatch(method, params)
