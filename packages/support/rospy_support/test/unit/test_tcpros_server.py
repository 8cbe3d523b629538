"""rospy_support.tcpros_server: headers that are slow, wrong or for a handler that waits keep nobody out."""
import io
import queue
import socket
import threading

import pytest
import rosgraph.network

from rospy_support.inbound import SocketWatch
from rospy_support.tcpros_server import TcprosServer

DEADLINE = 10.0  # [s] for what takes milliseconds
SUBSCRIBER = rosgraph.network.encode_ros_handshake_header({'topic': '/map', 'callerid': '/viewer'})


@pytest.fixture
def server():
    """Yield (connect, headers, reports, free): the topic handler waits for ``free`` if the topic is /map."""
    headers, reports, free = queue.Queue(), queue.Queue(), threading.Event()

    def topic_handler(connection, address, header):
        headers.put(header['topic'])
        if header['topic'] == '/map':  # as if it wrote a latched map to a subscriber that does not read
            assert free.wait(DEADLINE)
        elif header['topic'] == '/fails':
            raise OSError('the peer has gone')
        return '' if header['topic'] == '/map' else 'no such topic'
    watch = SocketWatch(lambda *said: reports.put(said))
    listening, opened = socket.create_server(('127.0.0.1', 0)), []
    watch.listen(listening, TcprosServer(watch, topic_handler).serve)

    def connect(data):
        opened.append(socket.create_connection(listening.getsockname(), DEADLINE))
        opened[-1].sendall(data)
        return opened[-1]
    yield connect, headers, reports, free
    free.set()
    watch.close(listening)
    for connection in opened:
        connection.close()


def header_of(connection):
    return rosgraph.network.read_ros_handshake_header(connection, io.BytesIO(), 65536)


def test_a_subscriber_that_does_not_read_keeps_no_other_one_out(server):
    connect, headers, _, _ = server
    for _ in range(3):  # each stays in the handler
        connect(SUBSCRIBER)
        assert headers.get(timeout=DEADLINE) == '/map'


def test_a_header_that_never_ends_keeps_no_other_one_out(server):
    connect, headers, _, _ = server
    connect(SUBSCRIBER[:9])
    connect(SUBSCRIBER)
    assert headers.get(timeout=DEADLINE) == '/map'


@pytest.mark.parametrize('fields, said', [
    ({'topic': '/other', 'callerid': '/x'}, 'no such topic'),
    ({'callerid': '/x'}, 'no topic or service name detected')])
def test_a_refusal_is_answered_and_reported(server, fields, said):
    connect, _, reports, _ = server
    assert header_of(connect(rosgraph.network.encode_ros_handshake_header(fields))) == {'error': said}
    assert said in reports.get(timeout=DEADLINE)[1]


def test_an_error_of_the_handler_ends_only_its_connection(server):
    connect, headers, reports, _ = server
    failing = connect(rosgraph.network.encode_ros_handshake_header({'topic': '/fails'}))
    assert failing.recv(1) == b''
    assert 'OSError: the peer has gone' in reports.get(timeout=DEADLINE)[1]
    connect(SUBSCRIBER)
    assert [headers.get(timeout=DEADLINE) for _ in range(2)] == ['/fails', '/map']


def test_what_is_no_header_is_reported(server):
    connect, _, reports, _ = server
    connect(b'\4\0\0\0\xff\xff\xff\xff')
    assert 'its header cannot be read' in reports.get(timeout=DEADLINE)[1]
