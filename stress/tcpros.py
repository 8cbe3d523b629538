"""ROS's wire protocols, to do what rospy and roscpp never do. No node, no rospy.

Every wait has a deadline; without an answer it raises ``NeverAnswered``, which a campaign counts.
"""

import http.client
import itertools
import os
import socket
import struct
import threading
import time
import xmlrpc.client
from urllib.parse import urlparse
from xmlrpc.server import SimpleXMLRPCRequestHandler, SimpleXMLRPCServer

CALLER = '/stress'
DEADLINE = 10.0  # [s] within which any node answers, on a loaded machine too
LENGTH = struct.Struct('<I')
LARGEST_ANSWER = 1 << 28  # [bytes]


class NeverAnswered(RuntimeError):
    """No answer came within the deadline."""


class Closed(RuntimeError):
    """The node closed the connection instead of answering, or refused it."""


class _Transport(xmlrpc.client.Transport):
    def __init__(self, timeout):
        super().__init__()
        self._timeout = timeout

    def make_connection(self, host):
        if not self._connection or host != self._connection[0]:
            self._connection = host, http.client.HTTPConnection(host, timeout=self._timeout)
        return self._connection[1]


def api(uri, timeout=DEADLINE):
    """Return a proxy of a master's or node's XML-RPC API whose calls end after ``timeout`` [s]."""
    return xmlrpc.client.ServerProxy(uri, transport=_Transport(timeout), allow_none=True)


class AnyCall:
    """An XML-RPC client that can call any method name, also those that ServerProxy uses itself."""

    def __init__(self, uri, timeout=DEADLINE):
        self._host, self._transport = urlparse(uri).netloc, _Transport(timeout)

    def __call__(self, method, arguments):
        body = xmlrpc.client.dumps(tuple(arguments), method, allow_none=True).encode('utf-8', 'surrogatepass')
        try:
            return self._transport.request(self._host, '/RPC2', body)
        except socket.timeout:
            raise NeverAnswered(method) from None


def header(**fields):
    """Return the bytes of a connection header."""
    parts = [f'{name}={value}'.encode() for name, value in fields.items()]
    body = b''.join(LENGTH.pack(len(part)) + part for part in parts)
    return LENGTH.pack(len(body)) + body


def framed(data):
    """Return a message or request with its length before it."""
    return LENGTH.pack(len(data)) + data


def address(uri):
    """Return the (host, port) of a URI."""
    parsed = urlparse(uri)
    return parsed.hostname, parsed.port


def connect(place, timeout=DEADLINE):
    """Return a TCP connection to (host, port)."""
    try:
        connection = socket.create_connection(place, timeout)
    except socket.timeout:
        raise NeverAnswered(f'no connection to port {place[1]}') from None
    except OSError as error:
        raise Closed(str(error)) from None
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return connection


def receive(connection, count):
    """Return exactly ``count`` bytes."""
    parts = []
    while count:
        try:
            part = connection.recv(min(count, 1 << 16))
        except socket.timeout:
            raise NeverAnswered('no answer') from None
        except OSError as error:
            raise Closed(str(error)) from None
        if not part:
            raise Closed('closed')
        parts.append(part)
        count -= len(part)
    return b''.join(parts)


def receive_frame(connection):
    """Return the bytes of one frame."""
    length = LENGTH.unpack(receive(connection, LENGTH.size))[0]
    if length > LARGEST_ANSWER:
        raise Closed(f'a frame of {length} bytes')
    return receive(connection, length)


def send(connection, data):
    """Send all bytes."""
    try:
        connection.sendall(data)
    except socket.timeout:
        raise NeverAnswered('nobody reads') from None
    except OSError as error:
        raise Closed(str(error)) from None


class Caller:
    """A persistent connection to a service at ``place`` (host, port); kind: its class, such as turtlesim.srv.Spawn.

    With ``send`` and ``answer``, many connections can wait at once.
    """

    def __init__(self, place, name, kind, timeout=DEADLINE):
        self._socket = connect(place, timeout)
        try:
            send(self._socket, header(callerid=CALLER, service=name, md5sum=kind._md5sum, type=kind._type,
                                      persistent='1'))
            receive_frame(self._socket)
        except (NeverAnswered, Closed):
            self.close()
            raise

    def send(self, request):
        """Send the bytes of a request."""
        send(self._socket, framed(request))

    def answer(self):
        """Return (accepted, bytes of the response or of the error's text)."""
        accepted = receive(self._socket, 1) == b'\x01'
        return accepted, receive_frame(self._socket)

    def call(self, request=b''):
        """Send and answer."""
        self.send(request)
        return self.answer()

    def close(self):
        """Close the connection; twice is harmless."""
        self._socket.close()


_NUMBERS = itertools.count(1)


def subscription(topic, kind):
    """Return the header of a new caller: rospy closes a connection when another one of the same caller comes."""
    return header(callerid=f'{CALLER}_{next(_NUMBERS)}_{os.getpid()}', topic=topic, md5sum=kind._md5sum,
                  type=kind._type, tcp_nodelay='1')


def subscribe(uri, topic, kind, timeout=DEADLINE, buffer=None):
    """Return a socket that receives the messages of a topic, after the headers; ``buffer`` [bytes]: the receiver's."""
    code, status, protocol = api(uri, timeout).requestTopic(CALLER, topic, [['TCPROS']])
    if code != 1 or not protocol:
        raise Closed(f'requestTopic {topic}: {status}')
    connection = socket.socket()
    if buffer:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
    connection.settimeout(timeout)
    try:
        connection.connect(tuple(protocol[1:3]))
        send(connection, subscription(topic, kind))
        receive_frame(connection)
    except socket.timeout:
        connection.close()
        raise NeverAnswered(f'no subscription of {topic}') from None
    except OSError as error:
        connection.close()
        raise Closed(str(error)) from None
    except (NeverAnswered, Closed):
        connection.close()
        raise
    return connection


class Receiver:
    """Receives a topic in a thread; notes how many messages came, and when [s, time.monotonic]."""

    def __init__(self, connection):
        self._socket = connection
        self.stamps = []
        self.last = b''
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self):
        try:
            while True:
                self.last = receive_frame(self._socket)
                self.stamps.append(time.monotonic())
        except (NeverAnswered, Closed):
            pass

    def close(self):
        """End it."""
        try:
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        self._thread.join()
        self._socket.close()


class _Quiet(SimpleXMLRPCRequestHandler):
    def log_message(self, *_):
        pass


class Publisher:
    """A publisher with its own slave API; ``connections`` are the sockets of its subscribers.

    Registered with the master as CALLER; ``hello`` is what it answers to a header (by default: a right one).
    """

    def __init__(self, master_uri, topic, kind, hello=None):
        self._hello = hello or header(callerid=CALLER, topic=topic, md5sum=kind._md5sum, type=kind._type,
                                      message_definition=kind._full_text, latching='0')
        self._listener = socket.create_server(('127.0.0.1', 0))
        self.connections = []
        self._server = SimpleXMLRPCServer(('127.0.0.1', 0), requestHandler=_Quiet, logRequests=False)
        self._server.register_function(self._request_topic, 'requestTopic')
        self._server.register_function(lambda *_: [1, '', 0], 'publisherUpdate')
        self._server.register_function(lambda *_: [1, '', 1], 'getPid')
        for target in (self._server.serve_forever, self._accept):
            threading.Thread(target=target, daemon=True).start()
        self.uri = f'http://127.0.0.1:{self._server.server_address[1]}/'
        self._master, self._topic = api(master_uri), topic
        self._master.registerPublisher(CALLER, topic, kind._type, self.uri)

    def _request_topic(self, *_):
        return [1, '', ['TCPROS', '127.0.0.1', self._listener.getsockname()[1]]]

    def _accept(self):
        while True:
            try:
                connection, _ = self._listener.accept()
                connection.settimeout(DEADLINE)
                receive_frame(connection)
                connection.sendall(self._hello)
            except (NeverAnswered, Closed):
                continue
            except OSError:
                return
            self.connections.append(connection)

    def publish(self, data):
        """Send a message's bytes, framed, to every subscriber; return the number of subscribers."""
        return self.publish_raw(framed(data))

    def publish_raw(self, data):
        """Send bytes as they are, drop subscribers that do not take them, and return the number of the others."""
        for connection in list(self.connections):
            try:
                connection.sendall(data)
            except OSError:
                self.connections.remove(connection)
                connection.close()
        return len(self.connections)

    def close(self):
        """Unregister and close everything."""
        try:
            self._master.unregisterPublisher(CALLER, self._topic, self.uri)
        except (OSError, xmlrpc.client.Error, http.client.HTTPException):
            pass
        self._server.shutdown()
        self._server.server_close()
        try:
            self._listener.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        self._listener.close()
        for connection in self.connections:
            connection.close()
