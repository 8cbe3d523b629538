"""ROS's wire protocols by raw sockets: thousands of connections in one process, and bytes that rospy never sends.

Imports no rospy. Every wait has a deadline: ``socket.timeout`` means that the other side did not answer; ``Closed`` or
another OSError, that it ended the connection.
"""
import io
import os
import socket
import struct
import threading
import time
import xmlrpc.client
from http.client import HTTPException
from urllib.parse import urlparse

import psutil

from rospy_support.limited_transport import LimitedTransport

CALLER = '/raw_client'
DEADLINE = 15.0  # [s] for an answer that takes milliseconds on an idle machine
LENGTH = struct.Struct('<I')
LARGEST_ANSWER = 1 << 28  # [bytes]
LOG = {'topic': '/rosout', 'type': 'rosgraph_msgs/Log', 'md5sum': 'acffd30cd6b6de30f120938c17c593fb'}
TROUBLE = (OSError, xmlrpc.client.Error, HTTPException)  # raised by the functions below if a node misbehaves


class Closed(ConnectionError):
    """The other side closed the connection, or refused it with a text."""


def api(uri, timeout=DEADLINE):
    """Return a proxy of the XML-RPC API at a URI; each of its calls ends after ``timeout`` [s]."""
    return xmlrpc.client.ServerProxy(uri, transport=LimitedTransport(timeout), allow_none=True)


def any_call(uri, method, arguments):
    """Call a method of an XML-RPC API, also one whose name ServerProxy uses itself; return the answer."""
    body = xmlrpc.client.dumps(tuple(arguments), method, allow_none=True).encode('utf-8', 'surrogatepass')
    return LimitedTransport(DEADLINE).request(urlparse(uri).netloc, '/RPC2', body)


def address(uri):
    """Return the (host, port) of a URI."""
    parsed = urlparse(uri)
    return parsed.hostname, parsed.port


def block(data):
    """Return bytes with their length before them."""
    return LENGTH.pack(len(data)) + data


def header(**fields):
    """Return the bytes of a TCPROS header."""
    return block(b''.join(block(f'{key}={value}'.encode()) for key, value in fields.items()))


def serialized(message):
    """Return the bytes of a message or request."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def connect(place, data=b'', timeout=DEADLINE):
    """Return a TCP connection to (host, port) on which ``data`` has been sent."""
    connection = socket.create_connection(place, timeout)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    connection.sendall(data)
    return connection


def receive(connection, size):
    """Return exactly ``size`` bytes."""
    parts, left = [], size
    while left:
        part = connection.recv(min(left, 1 << 16))
        if not part:
            raise Closed(f'closed after {size - left} of {size} bytes')
        parts.append(part)
        left -= len(part)
    return b''.join(parts)


def receive_block(connection):
    """Return the bytes of a block, without its length."""
    size, = LENGTH.unpack(receive(connection, LENGTH.size))
    if size > LARGEST_ANSWER:
        raise Closed(f'a block of {size} bytes was announced')
    return receive(connection, size)


def receive_header(connection):
    """Return the header that comes as {field: text}."""
    data, fields, start = receive_block(connection), {}, 0
    while start < len(data):
        size, = LENGTH.unpack_from(data, start)
        key, _, value = data[start + 4:start + 4 + size].decode().partition('=')
        fields[key] = value
        start += 4 + size
    return fields


def receive_answer(connection):
    """Return (whether a call went well, the bytes of its answer)."""
    return receive(connection, 1) == b'\1', receive_block(connection)


def is_closed(connection):
    """Return whether the other side has closed a connection; unread bytes are dropped."""
    connection.setblocking(False)
    try:
        while connection.recv(1 << 16):
            pass
        return True
    except BlockingIOError:
        return False
    except OSError:
        return True


def opened(place, timeout=DEADLINE, **fields):
    """Return (answer, connection) after the headers have been exchanged; ``answer`` is a dictionary."""
    connection = connect(place, header(**fields), timeout)
    try:
        return receive_header(connection), connection
    except OSError:
        connection.close()
        raise


def tcpros_address(uri, topic='/rosout'):
    """Return the (host, port) at which the node with this URI serves a topic; its services are there, too."""
    code, text, protocol = api(uri).requestTopic(CALLER, topic, [['TCPROS']])
    if code != 1:
        raise Closed(text)
    return tuple(protocol[1:])


def subscribe(uri, topic, kind):
    """Return a connection on which messages of class ``kind`` come from the node with this URI."""
    # Other names for each: nodes drop a second connection of the same caller to a topic.
    answer, connection = opened(tcpros_address(uri, topic), callerid=f'{CALLER}_{os.urandom(4).hex()}', topic=topic,
                                type=kind._type, md5sum=kind._md5sum, tcp_nodelay='1')
    if 'error' in answer:
        connection.close()
        raise Closed(answer['error'])
    return connection


class Caller:
    """A persistent connection to a service at ``place``; kind: its class. Many can wait at once."""

    def __init__(self, place, name, kind, timeout=DEADLINE):
        answer, self.socket = opened(place, timeout, callerid=CALLER, service=name, md5sum=kind._md5sum,
                                     persistent='1', tcp_nodelay='1')
        self.kind = kind
        if 'error' in answer:
            self.socket.close()
            raise Closed(answer['error'])

    def send(self, *values):
        """Send a request with these values of its fields."""
        self.socket.sendall(block(serialized(self.kind._request_class(*values))))

    def answer(self):
        """Return (whether the call went well, the bytes of its answer)."""
        return receive_answer(self.socket)

    def call(self, *values):
        """Send a request and return its answer."""
        self.send(*values)
        return self.answer()


class Receiver:
    """Receives messages from a connection in a thread; notes when [s, time.monotonic] each came."""

    def __init__(self, connection):
        self._socket = connection
        self.stamps = []
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self):
        try:
            while True:
                receive_block(self._socket)
                self.stamps.append(time.monotonic())
        except OSError:
            pass

    def close(self):
        """End it."""
        try:
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        self._thread.join()
        self._socket.close()


class Peer:
    """A node seen from outside. Every node has the topic /rosout and the services ~get_loggers, ~set_logger_level."""

    def __init__(self, name, uri):
        self.name, self.uri = name, uri
        self.slave = api(uri)
        self.pid = self.slave.getPid(CALLER)[2]
        self.process = psutil.Process(self.pid)
        self.slave_address, self.address = address(uri), tcpros_address(uri)

    def subscribe(self, **changed):
        """Subscribe to /rosout; return (answer, connection)."""
        return opened(self.address, **{'callerid': CALLER, **LOG, **changed})

    def open_service(self, service='get_loggers', **changed):
        """Return (answer, connection) to a service of the node."""
        return opened(self.address, **{'callerid': CALLER, 'service': f'{self.name}/{service}', 'md5sum': '*',
                                       **changed})

    def call(self, request=b'', service='get_loggers', **changed):
        """Call a service with the bytes of a request; return (whether it went well, the bytes of its answer)."""
        answer, connection = self.open_service(service, **changed)
        with connection:
            if 'error' in answer:
                raise Closed(answer['error'])
            connection.sendall(block(request))
            return receive_answer(connection)

    def answers(self):
        """Subscribe as a new subscriber does and call a service; return how long [s] each took, or raise TROUBLE."""
        begin = time.monotonic()
        tcpros_address(self.uri)
        answer, connection = self.subscribe()
        connection.close()
        if answer.get('md5sum') != LOG['md5sum']:
            raise Closed(f'a subscriber was answered {answer}')
        middle = time.monotonic()
        if not self.call()[0]:
            raise Closed('get_loggers failed')
        return middle - begin, time.monotonic() - middle

    def threads(self):
        """Return how many threads its process has."""
        return self.process.num_threads()

    def descriptors(self):
        """Return how many file descriptors its process has open."""
        return self.process.num_fds()
