#!/usr/bin/env python3
"""Attacks on the web servers: broken bytes, floods and crowds. A client beside them notices nothing.

Which refusal each wrong frame, operation, host, origin and query gets is a matter of the unit tests of browser_servers.
"""
import contextlib
import http.client
import json
import random
import re
import socket
import threading
import time
import unittest

import cbor2
import rospy

from attacked_nodes import running
from rostest_support import tcpros
from rostest_support.common import run, until
from rostest_support.websocket_client import BINARY, TEXT, Ended, WebSocket, frame, handshake, masked

HERE = '127.0.0.1'
SERVERS = 'rosbridge', 'browser', 'web_video'
BROKEN = 500  # broken inputs of each server
HALF_OPEN, CROWD = 50, 250  # connections at once
LIMIT = 10_000_000  # [B] of a message, by default
LARGE = 100 * 10 ** 6  # [B]
CHUNK = 1 << 20  # [B]
GAP = 5.0  # [s] in which a client beside it gets no pose; 0.1 s on a machine that does nothing else
MEMORY = 400.0  # [MB]
ANY_CODE = 1000  # the least code of a close frame
SPARE = 8  # descriptors and threads that may come and go: its own calls to the master and clients
OPERATIONS = (
    {'op': 'advertise', 'topic': '/web', 'type': 'std_msgs/String'}, {'op': 'unadvertise', 'topic': '/web'},
    {'op': 'publish', 'topic': '/web', 'msg': {'data': 'x'}}, {'op': 'subscribe', 'topic': '/turtle1/pose'},
    {'op': 'publish', 'topic': '/turtle1/cmd_vel', 'msg': {'linear': {'x': 0.0}}},
    {'op': 'call_service', 'service': '/rosapi/get_time', 'args': {}},
    {'op': 'advertise_service', 'service': '/web', 'type': 'std_srvs/Empty'},
    {'op': 'service_response', 'service': '/web', 'id': 'x', 'values': {}, 'result': True},
    {'op': 'fragment', 'id': 'x', 'data': '', 'num': 0, 'total': 1}, {'op': 'png', 'data': ''},
    {'op': 'set_level', 'level': 'error'}, {'op': 'deadman', 'timeout': 1.0})
REQUESTS = b'GET / HTTP/1.1\r\n', b'GET /stream?topic= HTTP/1.1\r\n', b'POST / HTTP/1.1\r\nContent-Length: 5\r\n'


class Witness:
    """A client of the rosbridge server that gets a turtle's poses: what others do must not disturb it."""

    def __init__(self, place):
        self._socket = WebSocket(place, tcpros.DEADLINE)
        self._stamps, self._answered = [], threading.Event()
        self._socket.subscribe('/turtle1/pose', 'turtlesim/Pose')
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()
        until(lambda: self._stamps, 'a pose at the client beside')

    def _run(self):
        with contextlib.suppress(OSError):
            while True:
                for received in self._socket.frames():
                    if b'"publish"' in received:
                        self._stamps.append(time.monotonic())
                    else:
                        self._answered.set()

    def close(self):
        """Call a service, and stop; return the longest time [s] without a pose."""
        self._socket.send(op='call_service', service='/rosapi/get_time')
        assert self._answered.wait(tcpros.DEADLINE), 'a call of the client beside has no answer'
        self._socket.socket.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self._socket.close()
        return max(later - earlier for earlier, later in zip(self._stamps, self._stamps[1:]))


def broken(numbers, data):
    """Return bytes with some of them changed, cut out or repeated."""
    data = bytearray(data)
    for _ in range(numbers.randint(1, 4)):
        at, end = sorted(numbers.randrange(len(data) + 1) for _ in range(2))
        end = min(end, at + 20)
        data[at:end] = numbers.choice((b'', data[at:end] * 9, bytes(numbers.randrange(256) for _ in range(end - at))))
    return bytes(data)


def garbage(numbers, speaks_websocket):
    """Return bytes that are nearly a request, or after a handshake nearly a frame, or a message."""
    if not speaks_websocket or numbers.random() < 0.2:
        return broken(numbers, numbers.choice(REQUESTS) + b'Host: 127.0.0.1\r\n\r\n')
    operation, opcode = numbers.choice(OPERATIONS), numbers.choice((TEXT, BINARY))
    message = json.dumps(operation).encode() if opcode == TEXT else cbor2.dumps(operation)
    if numbers.random() < 0.5:
        return handshake({}) + broken(numbers, frame(opcode, message))
    return handshake({}) + frame(opcode, broken(numbers, message))


def one_frame():
    yield frame(TEXT, b'', length=LARGE)
    for _ in range(LARGE // CHUNK):
        yield bytes(CHUNK)


def many_frames():
    yield frame(TEXT, bytes(CHUNK), 0)
    for _ in range(LARGE // CHUNK):
        yield frame(0, bytes(CHUNK), 0)


def fragments():
    total = LARGE // CHUNK
    for number in range(total):
        yield masked({'op': 'fragment', 'id': 'large', 'num': number, 'total': total, 'data': 'x' * CHUNK})


def is_answered(client):
    """Return whether the server next sends an error with a text, or a close frame with a code and a text."""
    try:
        while True:
            for received in client.frames():
                answer = json.loads(received)
                if answer['op'] == 'status':
                    return answer['level'] == 'error' and bool(answer['msg'])
                if answer['op'] == 'service_response':
                    return answer['result'] is False and bool(answer['values'])
    except Ended as ended:
        return ended.code is not None and ended.code >= ANY_CODE and bool(ended.reason)


class WebGarbageTest(unittest.TestCase):

    @contextlib.contextmanager
    def attacked(self):
        """Yield {key: place} of the servers beside a Witness; assert afterwards that they lost nothing."""
        with contextlib.ExitStack() as stack:
            nodes = running(stack, ('turtlesim', *SERVERS))
            servers = {key: nodes[key].peer for key in SERVERS}
            places = {key: (HERE, until(lambda peer=peer: rospy.get_param(f'{peer.name}/actual_port', None)))
                      for key, peer in servers.items()}
            for peer in servers.values():
                peer.answers()  # the node now has everything open that a first listener needs
            before = {key: (peer.descriptors(), peer.threads()) for key, peer in servers.items()}
            witness = Witness(places['rosbridge'])
            yield places
            self.assertLess(witness.close(), GAP, 'seconds without a pose')
            for key, peer in servers.items():
                self.assertEqual([], nodes[key].troubles())
                peer.answers()
                until(lambda key=key, peer=peer: peer.descriptors() <= before[key][0] + SPARE
                      and peer.threads() <= before[key][1] + SPARE, f'{key} has released what its clients left')
                with open(f'/proc/{peer.pid}/status', encoding='utf-8') as file:
                    memory = int(re.search(r'VmHWM:\s*(\d+)', file.read())[1]) * 1024 / 1e6
                self.assertLess(memory, MEMORY, f'{key}: MB at most')

    def test_broken_requests_frames_and_messages(self):
        numbers = random.Random(1)
        with self.attacked() as places:
            for key, place in places.items():
                for _ in range(BROKEN):
                    self.until_it_ends(place, garbage(numbers, key != 'web_video'))

    def until_it_ends(self, place, data):
        """Send bytes and the end; wait until the server has closed the connection."""
        with contextlib.suppress(ConnectionError), tcpros.connect(place, data) as connection:
            with contextlib.suppress(OSError):
                connection.shutdown(socket.SHUT_WR)
            while connection.recv(CHUNK):
                pass

    def test_floods_and_crowds(self):
        with self.attacked() as places:
            for key in ('rosbridge', 'browser'):
                for make in (one_frame, many_frames, fragments):
                    self.flood(key, places[key], make)
            for key, place in places.items():
                self.half_open(key, place)
            for key in ('rosbridge', 'browser'):
                self.crowd(key, places[key])

    def flood(self, key, place, make):
        """A message of 100 MB is answered."""
        client = WebSocket(place, tcpros.DEADLINE)
        with contextlib.closing(client):
            with contextlib.suppress(BrokenPipeError, ConnectionResetError):
                for part in make():
                    client.socket.sendall(part)
            self.assertTrue(is_answered(client), f'{key} does not say why it refuses {make.__name__}')

    def half_open(self, key, place):
        """Connections that say nothing, or a part of a request or of a frame; a client beside them gets its answer."""
        parts = [b'', b'GET', b'GET / HTTP/1.1\r\nHost: ', handshake({})]
        if key != 'web_video':
            parts += [handshake({}) + frame(TEXT, b'x', length=LIMIT - 1), handshake({}) + b'\x81']
        with contextlib.ExitStack() as stack:
            for number in range(HALF_OPEN):
                stack.enter_context(tcpros.connect(place, parts[number % len(parts)]))
            connection = http.client.HTTPConnection(*place, timeout=tcpros.DEADLINE)
            stack.callback(connection.close)
            connection.request('GET', '/')
            self.assertIn(connection.getresponse().status, (200, 404), key)

    def crowd(self, key, place):
        """So many clients at once: each is accepted, or refused with 503 and a reason."""
        accepted = 0
        with contextlib.ExitStack() as stack:
            for _ in range(CROWD):
                try:
                    stack.callback(WebSocket(place, tcpros.DEADLINE).close)
                    accepted += 1
                except Ended as ended:
                    self.assertEqual(503, ended.code)
                    self.assertIn('connected already', ended.reason)
        self.assertLess(0, accepted)
        self.assertLess(accepted, CROWD, f'{key} has no limit of clients')


if __name__ == '__main__':
    run(WebGarbageTest)
