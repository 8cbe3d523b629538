"""A node's XML-RPC server (the slave API of ROS); a SocketWatch reads its requests, see inbound.py."""
import functools
import io
import socket
import threading

import rosgraph.xmlrpc

from rospy_support.inbound import BACKLOG, HttpReader, Refused

BODY_LIMIT = 4 << 20  # [bytes] of a request; the longest ones of ROS hold a list of publishers, or a parameter
FIRST_DEADLINE = 15.0  # [s] for the first request of a connection
NEXT_DEADLINE = 60.0  # [s] for each further request; the master keeps its connections open
SEND_DEADLINE = 30.0  # [s] for the peer to read the answer
REFUSAL = b'HTTP/1.1 413 Payload Too Large\r\nContent-Length: 0\r\nConnection: close\r\n\r\n'


class SlaveServer(rosgraph.xmlrpc.ThreadingXMLRPCServer):
    """Replaces rosgraph's server, which starts a thread for each connection; here each complete request gets one."""

    def __init__(self, watch, address, log_requests=1):
        self._watch, self._closed = watch, threading.Event()
        super().__init__(address, log_requests)

    def server_activate(self):
        """Listen; called by the constructor."""
        self.socket.listen(BACKLOG)

    def serve_forever(self, poll_interval=0.5):
        """Let the watch accept connections until the server is closed."""
        self._watch.listen(self.socket, self._accepted)
        self._closed.wait()

    def server_close(self):
        """Close the listening socket."""
        self._closed.set()
        self._watch.close(self.socket)

    def _accepted(self, connection, address):
        self._wait(connection, address, FIRST_DEADLINE)

    def _wait(self, connection, address, deadline):
        self._watch.read(connection, HttpReader(BODY_LIMIT), functools.partial(self._start_answer, address),
                         functools.partial(self._failed, address), deadline)

    def _start_answer(self, address, connection, request):
        threading.Thread(target=self._answer, args=(connection, address, request), daemon=True).start()

    def _failed(self, address, connection, error):
        if isinstance(error, Refused):
            self._watch.report('refused', f'Closed a connection of {address[0]} to the XML-RPC server: {error}.')
            try:
                connection.send(REFUSAL)
            except OSError:
                pass
        connection.close()

    def _answer(self, connection, address, request):
        try:
            connection.settimeout(SEND_DEADLINE)
            keep = not _RequestHandler(connection, address, self, request).close_connection
        except Exception:  # the peer has gone, or its data are not HTTP; logged to the file, as rosgraph does
            self.handle_error(connection, address)
            keep = False
        if keep:
            self._wait(connection, address, NEXT_DEADLINE)
        else:
            try:
                connection.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
            connection.close()


class _RequestHandler(rosgraph.xmlrpc.SilenceableXMLRPCRequestHandler):
    """Answers one request that has already been read."""

    def __init__(self, connection, address, server, request):
        self._request = request
        super().__init__(connection, address, server)

    def setup(self):
        super().setup()
        self.rfile.close()
        self.rfile = io.BytesIO(self._request)

    def handle(self):
        self.close_connection = True
        self.handle_one_request()
