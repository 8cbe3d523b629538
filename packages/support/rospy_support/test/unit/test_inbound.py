"""rospy_support.inbound: connections that say nothing, little or too much, and a process without file descriptors."""
import asyncio
import contextlib
import errno
import queue
import socket
import struct
import threading
import time

import pytest

from rospy_support import inbound
from rospy_support.inbound import Ended, Refused, SocketWatch, read_block, read_http
from rostest_support.waiting import until

DEADLINE = 10.0  # [s] for what takes milliseconds
LIMIT = 1000  # [bytes]


class Watched:
    """A SocketWatch with a listening socket; blocks, failures and reports come in queues."""

    def __init__(self):
        self.blocks, self.failures, self.reports = queue.Queue(), queue.Queue(), queue.Queue()
        self.watch = SocketWatch(lambda *said: self.reports.put(said))
        self.listening = socket.create_server(('127.0.0.1', 0))
        self.read, self.deadline = read_block, 60.0
        self._open = contextlib.ExitStack()

    def listen(self):
        self.watch.listen(self.listening, self.serve)

    async def serve(self, connection, address):
        self._open.callback(connection.close)
        self.left = connection
        try:
            self.blocks.put(await self.watch.read(self.read(connection, LIMIT), self.deadline))
        except (Ended, Refused) as error:
            self.failures.put(error)

    def connect(self, data=b''):
        connection = socket.create_connection(self.listening.getsockname(), DEADLINE)
        self._open.callback(connection.close)
        connection.sendall(data)
        return connection

    def block(self):
        return self.blocks.get(timeout=DEADLINE)

    def failure(self, kind):
        error = self.failures.get(timeout=DEADLINE)
        assert isinstance(error, kind)
        return str(error)

    def close(self):
        self.watch.close(self.listening)
        self._open.close()


@pytest.fixture
def watched():
    made = Watched()
    yield made
    made.close()


@pytest.fixture
def listening(watched):
    watched.listen()
    return watched


def test_a_block_byte_by_byte(listening):
    connection, data = listening.connect(), struct.pack('<I', 3) + b'abc'
    for byte in data[:-1]:
        connection.send(bytes([byte]))
        assert listening.blocks.empty()
    connection.send(data[-1:] + b'next')
    assert listening.block() == b'abc'
    assert listening.left.recv(10) == b'next'  # not a byte more was taken


@pytest.mark.parametrize('size', [0, 1, LIMIT])
def test_blocks_up_to_the_limit(listening, size):
    listening.connect(struct.pack('<I', size) + b'.' * size)
    assert listening.block() == b'.' * size


def test_a_block_beyond_the_limit(listening):
    listening.connect(struct.pack('<I', LIMIT + 1))
    assert listening.failure(Refused) == 'a length of 1001 bytes; at most 1000 are allowed'


def test_the_end_of_a_connection(listening):
    listening.connect(b'\1\0').close()
    assert listening.failure(Ended) == 'closed'


def test_a_connection_that_is_reset(listening):
    connection = listening.connect(b'\1')
    until(lambda: listening.watch._waiting)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack('ii', 1, 0))
    connection.close()
    assert 'reset' in listening.failure(Ended)


@pytest.mark.parametrize('request_text', [
    b'POST / HTTP/1.1\r\nContent-Length: 3\r\n\r\nabc', b'POST / HTTP/1.0\r\ncontent-length:3\r\nX: y\r\n\r\nabc',
    b'GET / HTTP/1.1\r\n\r\n'])
def test_http_requests(listening, request_text):
    listening.read = read_http
    connection = listening.connect(request_text[:-1])
    assert listening.blocks.empty()
    connection.send(request_text[-1:])
    assert listening.block() == request_text


@pytest.mark.parametrize('head, said', [
    (b'Content-Length: 1001', 'an HTTP body of 1001 bytes; at most 1000'), (b'Content-Length: -1', 'must be a number'),
    (b'Content-Length: ' + b'9' * 30, 'at most 1000'), (b'Content-Length: ' + b'9' * 9000, 'at most 1000'),
    (b'Content-Length: ', 'must be a number'), (b'x' * (inbound.HEADER_LIMIT + 1), 'header of more than')])
def test_http_that_is_refused(listening, head, said):
    listening.read = read_http
    listening.connect(b'POST / HTTP/1.1\r\n' + head + (b'' if head.startswith(b'x') else b'\r\n\r\n'))
    assert said in listening.failure(Refused)


def test_idle_connections_cost_no_thread_and_keep_nobody_out(listening):
    threads = threading.active_count()
    for _ in range(300):
        listening.connect()
    listening.connect(struct.pack('<I', 2) + b'ok')
    assert listening.block() == b'ok'
    assert threading.active_count() <= threads  # those of other tests may end


def test_a_slow_peer_is_dropped_at_its_deadline(listening):
    listening.deadline = 0.05
    listening.connect()
    assert listening.failure(Ended) == 'too slow'


def test_a_deadline_ends_with_its_block(watched):
    """The coroutine then does something that takes longer."""
    async def serve(connection, address):
        block = await watched.watch.read(read_block(connection, LIMIT), 0.05)
        await asyncio.sleep(0.1)
        watched.blocks.put(block)
    watched.serve = serve
    watched.listen()
    watched.connect(struct.pack('<I', 2) + b'ok')
    assert watched.block() == b'ok'


def test_a_standstill_of_the_process_is_not_the_peers_fault(listening):
    """The process is suspended for ten seconds; data that arrive afterwards are read."""
    stopped_for = [0.0]
    listening.watch._loop.time = lambda: time.monotonic() + stopped_for[0]
    listening.deadline = 5.0
    late = listening.connect()
    until(lambda: listening.watch._waiting)
    stopped_for[0] = 10.0
    late.sendall(struct.pack('<I', 2) + b'ok')
    assert listening.block() == b'ok'


def test_without_descriptors_the_longest_waiting_make_room(watched):
    accepting, failing = watched.listening, [0]
    watched.listening = Listening(accepting, failing)
    watched.listen()
    for _ in range(20):
        watched.connect()
    until(lambda: len(watched.watch._waiting) == 20)
    failing[0] = 1
    watched.connect(struct.pack('<I', 2) + b'ok')
    assert watched.block() == b'ok'
    assert watched.failures.qsize() == 2  # a tenth of those that waited
    kind, text = watched.reports.get(timeout=DEADLINE)
    assert kind == 'descriptors' and 'Too many open files' in text and 'ulimit -n' in text


@pytest.mark.parametrize('number', [errno.EMFILE, errno.ENFILE, errno.ECONNABORTED, errno.EPERM])
def test_an_accept_that_fails_is_tried_again(watched, monkeypatch, number):
    monkeypatch.setattr(inbound, 'RETRY', 0.01)
    watched.listening = Listening(watched.listening, [3], number)
    watched.listen()
    watched.connect(struct.pack('<I', 2) + b'ok')
    assert watched.block() == b'ok'


def test_a_listening_socket_that_is_closed_while_it_waits_for_files(watched, monkeypatch, caplog):
    monkeypatch.setattr(inbound, 'RETRY', 0.01)
    watched.listening = Listening(watched.listening, [1])
    watched.listen()
    watched.connect()
    watched.reports.get(timeout=DEADLINE)
    watched.watch.close(watched.listening)
    watched.listening = socket.create_server(('127.0.0.1', 0))
    turns = threading.Event()
    watched.watch.run(wait_and_set(2 * inbound.RETRY, turns))
    assert turns.wait(DEADLINE) and not caplog.records  # asyncio logs errors of its callbacks


async def wait_and_set(seconds, event):
    await asyncio.sleep(seconds)
    event.set()


class Listening:
    """A listening socket whose next accepts fail."""

    def __init__(self, listening, failing, number=errno.EMFILE):
        self._listening, self._failing, self._number = listening, failing, number

    def accept(self):
        if self._failing[0]:
            self._failing[0] -= 1
            raise OSError(self._number, 'failed')
        return self._listening.accept()

    def __getattr__(self, name):
        return getattr(self._listening, name)
