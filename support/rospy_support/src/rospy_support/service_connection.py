"""A connection to a service of this node: a SocketWatch reads each request, and a thread answers it.

Threading contract: the thread of a connection exists from a complete request to its answer, and LINGER longer if the
connection is persistent. A connection without a request has no thread.
"""
import socket
import struct
import threading

from rospy_support import rospy_internals
from rospy_support.inbound import Ended, FrameReader, Refused
from rospy_support.message_size import wrong_size

SIZE_LIMIT = 256 << 20  # [bytes] of a message or a request
FIRST_DEADLINE = 60.0  # [s] for the request, unless the connection is persistent
LINGER = 0.5  # [s] that a thread waits for the next request of a persistent connection
SEND_DEADLINE = 60.0  # [s] for the peer to read the answer


class ServiceConnection:
    """A connection after the exchange of headers."""

    def __init__(self, watch, service, connection, header):
        """``service`` is rospy's object, ``header`` {field: text} the caller's."""
        self._watch, self._service, self._header = watch, service, header
        self._transport = rospy_internals.transport_of(service, connection, header)
        self._persistent = header.get('persistent', '').lower() in ('1', 'true')

    def open(self, connection):
        """Let the watch read the next request."""
        self._wait(connection, FrameReader(SIZE_LIMIT), None if self._persistent else FIRST_DEADLINE)

    def _wait(self, connection, reader, deadline):
        self._watch.read(connection, reader, self._start_answer, self._failed, deadline)

    def _start_answer(self, connection, request):
        threading.Thread(target=self._serve, args=(connection, request), daemon=True).start()

    def _failed(self, connection, error):
        if isinstance(error, Refused):
            self._complain(f'announced {error}; the connection is closed')
        connection.close()

    def _serve(self, connection, request):
        """Answer a request, and further ones that come within LINGER."""
        try:
            connection.setblocking(True)
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, _timeval(SEND_DEADLINE))
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, _timeval(LINGER))
            while True:
                self._answer(connection, request)
                if not self._persistent:
                    connection.shutdown(socket.SHUT_RDWR)
                    break
                reader = FrameReader(SIZE_LIMIT)
                request = reader.read(connection)
                if request is None:
                    self._wait(connection, reader, None)
                    return
        except (Ended, OSError):  # the caller has gone
            pass
        except Refused as error:
            self._failed(connection, error)
        connection.close()

    def _answer(self, connection, data):
        wrong = wrong_size(self._service.request_class, data)
        if wrong:
            self._complain(f'sent a bad request: {wrong}')
            text = f'a request of {self._service.request_class._type} of {wrong}'
            connection.sendall(rospy_internals.service_error(text))
        else:
            rospy_internals.respond(self._service, self._transport, data)

    def _complain(self, what):
        self._watch.report('refused', f'{self._header["callerid"]} called {self._service.resolved_name} and {what}.')


def _timeval(seconds):
    """Return a time limit as a socket option; Python's settimeout would cost a system call at each use."""
    return struct.pack('ll', int(seconds), int(seconds % 1.0 * 1e6))
