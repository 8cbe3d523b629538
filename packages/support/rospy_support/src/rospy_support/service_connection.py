"""A connection to a service of this node: a SocketWatch reads each request, and a thread answers it.

The fault: rospy occupies a thread for each caller, and never answers a request that is too short.

Threading contract: the thread of a connection exists from a complete request to its answer, and LINGER longer if the
connection is persistent. A connection without a request has no thread.
"""
import select
import socket
import struct
import threading
from socket import socket as Socket
from typing import Any, Dict, Optional

from rospy_support import rospy_internals
from rospy_support.inbound import CHUNK, Ended, Refused, SocketWatch, read_block

SIZE_LIMIT = 256 << 20  # [bytes] of a message or a request
LINGER = 0.5  # [s] for the next request of a persistent connection, while its thread waits


class ServiceConnection:
    """A connection after the exchange of headers."""

    def __init__(self, watch: SocketWatch, service: Any, connection: Socket, header: Dict[str, str]) -> None:
        """``service`` is rospy's object, ``header`` {field: text} the caller's."""
        self._watch, self._service, self._connection, self._header = watch, service, connection, header
        self._transport = rospy_internals.transport_of(service, connection, header)
        self._persistent = header.get('persistent', '').lower() in ('1', 'true')

    async def serve(self) -> None:
        """Read the next request, and let a thread answer it."""
        try:
            request = await read_block(self._connection, SIZE_LIMIT)
        except Ended:
            self._connection.close()
        except Refused as error:
            self._report(f'announced {error}; the connection is closed')
            self._connection.close()
        else:
            threading.Thread(target=self._answer, args=(request,), daemon=True).start()

    def _answer(self, request: Optional[bytes]) -> None:
        """Answer a request, and further ones that come within LINGER."""
        connection = self._connection
        try:
            connection.setblocking(True)
            while request is not None:
                wrong = rospy_internals.respond(self._service, self._transport, request)
                if wrong:
                    self._report(f'sent {wrong}')
                if not self._persistent:
                    connection.close()
                    return
                request = self._complete_request()
            connection.setblocking(False)
            self._watch.run(self.serve())
        except OSError:  # the caller has gone
            connection.close()

    def _report(self, what: str) -> None:
        self._watch.report('refused', f'{self._header["callerid"]} called {self._service.resolved_name} and {what}.')

    def _complete_request(self) -> Optional[bytes]:
        """Return a request that arrives within LINGER, all of it at once; None if there is none."""
        poll = select.poll()
        poll.register(self._connection, select.POLLIN)
        if poll.poll(1000.0 * LINGER):
            data = self._connection.recv(CHUNK, socket.MSG_PEEK)
            if len(data) >= 4:
                size, = struct.unpack_from('<I', data)
                if len(data) >= 4 + size:
                    return self._connection.recv(4 + size)[4:]
        return None
