"""rospy_support.inbound: connections that say nothing, little or too much, and a process without file descriptors."""
import contextlib
import errno
import queue
import socket
import struct
import threading
import time

import pytest

from rospy_support import inbound
from rospy_support.inbound import Ended, FrameReader, HttpReader, Refused, SocketWatch

DEADLINE = 10.0  # [s] for what takes milliseconds
LIMIT = 1000  # [bytes]


@pytest.fixture
def pair():
    ours, theirs = socket.socketpair()
    ours.setblocking(False)
    with ours, theirs:
        yield ours, theirs


class Watched:
    """A SocketWatch with a listening socket; blocks, failures and reports come in queues."""

    def __init__(self):
        self.blocks, self.failures, self.reports = queue.Queue(), queue.Queue(), queue.Queue()
        self.watch = SocketWatch(lambda *said: self.reports.put(said))
        self.listening = socket.create_server(('127.0.0.1', 0))
        self.deadline = None
        self._open = contextlib.ExitStack()

    def listen(self):
        self.watch.listen(self.listening, self.accepted)

    def accepted(self, connection, address):
        self._open.callback(connection.close)
        self.watch.read(connection, FrameReader(LIMIT), lambda *done: self.blocks.put(done),
                        lambda *failed: self.failures.put(failed), self.deadline)

    def connect(self):
        connection = socket.create_connection(self.listening.getsockname(), DEADLINE)
        self._open.callback(connection.close)
        return connection

    def block(self):
        return self.blocks.get(timeout=DEADLINE)[1]

    def failure(self):
        return self.failures.get(timeout=DEADLINE)[1]

    def close(self):
        self.watch.close(self.listening)
        self._open.close()


@pytest.fixture
def watched():
    made = Watched()
    yield made
    made.close()


def test_a_frame_byte_by_byte(pair):
    reader, data = FrameReader(LIMIT), struct.pack('<I', 3) + b'abc'
    for byte in data[:-1]:
        pair[1].send(bytes([byte]))
        assert reader.read(pair[0]) is None
    pair[1].send(data[-1:] + b'next')
    assert reader.read(pair[0]) == b'abc'
    assert pair[0].recv(10) == b'next'  # not a byte more was taken


@pytest.mark.parametrize('size', [0, 1, LIMIT])
def test_frames_up_to_the_limit(pair, size):
    pair[1].send(struct.pack('<I', size) + b'.' * size)
    assert FrameReader(LIMIT).read(pair[0]) == b'.' * size


def test_a_frame_beyond_the_limit(pair):
    pair[1].send(struct.pack('<I', LIMIT + 1))
    with pytest.raises(Refused, match='a length of 1001 bytes; at most 1000 are allowed'):
        FrameReader(LIMIT).read(pair[0])


def test_a_long_frame_takes_turns_with_others(pair):
    size = (inbound.TURN + 3) * inbound.CHUNK
    sender = threading.Thread(target=pair[1].sendall, args=(struct.pack('<I', size) + b'.' * size,))
    sender.start()
    reader, block = FrameReader(size), None
    end = time.monotonic() + DEADLINE
    while block is None and time.monotonic() < end:
        block = reader.read(pair[0])
    sender.join(DEADLINE)
    assert len(block) == size


def test_the_end_of_a_connection(pair):
    pair[1].send(b'\1\0')
    pair[1].close()
    with pytest.raises(Ended):
        FrameReader(LIMIT).read(pair[0])


@pytest.mark.parametrize('request_text', [
    b'POST / HTTP/1.1\r\nContent-Length: 3\r\n\r\nabc', b'POST / HTTP/1.0\r\ncontent-length:3\r\nX: y\r\n\r\nabc',
    b'GET / HTTP/1.1\r\n\r\n'])
def test_http_requests(pair, request_text):
    reader = HttpReader(LIMIT)
    pair[1].send(request_text[:-1])
    assert reader.read(pair[0]) is None
    pair[1].send(request_text[-1:])
    assert reader.read(pair[0]) == request_text


@pytest.mark.parametrize('head, said', [
    (b'Content-Length: 1001', 'an HTTP body of 1001 bytes; at most 1000'), (b'Content-Length: -1', 'must be a number'),
    (b'Content-Length: ' + b'9' * 30, 'at most 1000'), (b'Content-Length: ', 'must be a number')])
def test_http_that_is_refused(pair, head, said):
    pair[1].send(b'POST / HTTP/1.1\r\n' + head + b'\r\n\r\n')
    with pytest.raises(Refused, match=said):
        HttpReader(LIMIT).read(pair[0])


def test_a_http_header_without_end(pair):
    sender = threading.Thread(target=pair[1].sendall, args=(b'x' * (inbound.HEADER_LIMIT + 1),))
    sender.start()
    with pytest.raises(Refused, match='header of more than'):
        reader = HttpReader(LIMIT)
        while True:
            reader.read(pair[0])
    sender.join(DEADLINE)


def test_idle_connections_cost_no_thread_and_keep_nobody_out(watched):
    watched.listen()
    threads = threading.active_count()
    for _ in range(300):
        watched.connect()
    watched.connect().sendall(struct.pack('<I', 2) + b'ok')
    assert watched.block() == b'ok'
    assert threading.active_count() == threads


def test_who_is_too_slow_is_given_up_and_others_are_not(watched, monkeypatch):
    monkeypatch.setattr(inbound, 'SWEEP', 0.01)
    watched.deadline = 0.05
    watched.listen()
    watched.connect()
    assert str(watched.failure()) == 'too slow'
    watched.deadline = None
    slow = watched.connect()
    assert watched.failures.empty()
    slow.sendall(struct.pack('<I', 0))
    assert watched.block() == b''


def test_a_standstill_of_the_process_is_not_the_peers_fault(watched, monkeypatch):
    """Ten seconds pass between two looks: they count as STANDSTILL."""
    clock = [0.0]
    monkeypatch.setattr(inbound.time, 'monotonic', lambda: clock[0])
    watched.deadline = 5.0
    watched.listen()
    late = watched.connect()
    until(lambda: watched.watch._waiting)
    clock[0] = 10.0
    watched.watch._do(lambda: None)
    late.sendall(struct.pack('<I', 2) + b'ok')
    assert watched.block() == b'ok'


def test_without_descriptors_the_longest_waiting_make_room(watched):
    watched.deadline = 60.0
    accepting, failing = watched.listening, [0]
    watched.listening = Listening(accepting, failing)
    watched.listen()
    for _ in range(20):
        watched.connect()
    until(lambda: len(watched.watch._waiting) == 20)
    failing[0] = 1
    watched.connect().sendall(struct.pack('<I', 2) + b'ok')
    assert watched.block() == b'ok'
    assert watched.failures.qsize() == 2  # a tenth of those that waited
    kind, text = watched.reports.get(timeout=DEADLINE)
    assert kind == 'descriptors' and 'Too many open files' in text and 'ulimit -n' in text


@pytest.mark.parametrize('number', [errno.EMFILE, errno.ENFILE, errno.ECONNABORTED, errno.EPERM])
def test_an_accept_that_fails_is_tried_again(watched, monkeypatch, number):
    monkeypatch.setattr(inbound, 'RETRY', 0.01)
    watched.listening = Listening(watched.listening, [3], number)
    watched.listen()
    watched.connect().sendall(struct.pack('<I', 2) + b'ok')
    assert watched.block() == b'ok'


def test_an_error_in_a_callback_does_not_end_the_thread(watched, monkeypatch):
    monkeypatch.setattr(inbound, 'RETRY', 0.01)
    watched.listen()
    watched.watch._do(lambda: 1 / 0)
    kind, text = watched.reports.get(timeout=DEADLINE)
    assert kind == 'internal' and 'ZeroDivisionError' in text
    watched.connect().sendall(struct.pack('<I', 0))
    assert watched.block() == b''


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


def until(condition):
    end = time.monotonic() + DEADLINE
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.001)
