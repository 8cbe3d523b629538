"""Attacks on the web servers: broken bytes, floods and crowds.

A client beside them must notice nothing. Which refusal each wrong frame, operation, host, origin and query gets is a
matter of the unit tests of browser_servers.
"""

import contextlib
import http.client
import json
import socket
import threading
import time

import cbor2

from figures import Figure, Target, intervals
from processes import peak_memory
from rostest_support import tcpros
from rostest_support.websocket_client import BINARY, TEXT, Ended, WebSocket, frame, handshake, masked
from trial import NOTHING, POLL, running, until

HERE = '127.0.0.1'
SERVERS = 'rosbridge', 'browser', 'web_video'
LIMIT = 10_000_000  # [B] of a message, by default
LARGE = 100 * 10 ** 6  # [B]
CHUNK = 1 << 20  # [B]
GAP = 1.0  # [s] in which a client beside it gets no pose
MEMORY = 400.0  # [MB]
ANY_CODE = 1000  # the least code of a close frame
SETTLED = 20.0  # [s] within which a server has released what its clients left
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


class Server:
    """A web server under attack: where it listens, and what is lost of what it is sent."""

    def __init__(self, node):
        self._node, self.key = node, node.kind.key
        self.place = HERE, until(self._port, f'the port of {self.key}')
        self.inputs = self._hung = 0
        self._unexplained = []
        node.answers()  # the node now has everything open that a first listener needs
        self._before = self._open()

    def _port(self):
        code, _, value = self._node.master.getParam(tcpros.CALLER, f'{self._node.kind.node}/actual_port')
        return value if code == 1 else None

    def _open(self):
        return self._node.peer.descriptors(), self._node.peer.threads()

    def answered(self, call, *arguments):
        """Count an input; ``call(...)`` sends it and waits. Return its value, None without an answer."""
        self.inputs += 1
        try:
            return call(*arguments)
        except socket.timeout:
            self._hung += 1
        except tcpros.TROUBLE:
            pass  # closed, or answered with an error: an answer, too
        return None

    def explained(self, attack, call, *arguments):
        """Do the same; ``call(...)`` returns whether the answer says why."""
        if not self.answered(call, *arguments):
            self._unexplained.append(attack)

    def client(self):
        """Return a connected client."""
        return WebSocket(self.place, tcpros.DEADLINE)

    def samples(self, name):
        """End the attack; return {key: samples} of all that was lost."""
        for attack in sorted(set(self._unexplained)):
            print(f'    {self.key} did not say why: {attack}', flush=True)
        found = {'inputs': self.inputs, 'hung': self._hung, 'unexplained': len(self._unexplained),
                 'ended': int(not self._node.child.runs())}
        if not found['ended']:
            found['memory'] = peak_memory(self._node.pid) / 1e6
            found['deaf'] = int(not self._node.answers())
            found['descriptors'], found['threads'] = self._left()
        return {f'{name}_{key}': [value] for key, value in found.items()}

    def _left(self):
        """Return how many more descriptors and threads there are than before; wait up to SETTLED for few."""
        end = time.monotonic() + SETTLED
        while True:
            left = [now - before for now, before in zip(self._open(), self._before)]
            if max(left) <= SPARE or time.monotonic() > end:
                return left
            time.sleep(POLL)


class Witness:
    """A client of the rosbridge server that gets a turtle's poses: what others do must not disturb it."""

    def __init__(self, server):
        self._socket = server.client()
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

    def samples(self, name):
        """Call a service, and stop; return the problems that were noticed."""
        with contextlib.suppress(OSError):
            self._socket.send(op='call_service', service='/rosapi/get_time')
        lost = not self._answered.wait(tcpros.DEADLINE)
        with contextlib.suppress(OSError):
            self._socket.socket.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self._socket.close()
        return {f'{name}_witness': [int(lost)], f'{name}_gap': [max(intervals(self._stamps), default=tcpros.DEADLINE)]}


@contextlib.contextmanager
def attacked(subject, name, found):
    """Yield the Servers by kind beside a Witness; put losses into ``found``."""
    with running(subject, 'turtlesim', *SERVERS) as nodes:
        servers = {key: Server(nodes[key]) for key in SERVERS}
        witness = Witness(servers['rosbridge'])
        yield servers
        parts = [witness.samples(name), *(server.samples(name) for server in servers.values())]
        for part in parts:
            for key, values in part.items():
                found.setdefault(key, []).extend(values)


def _broken(rng, data):
    """Return bytes with some of them changed, cut out or repeated."""
    data = bytearray(data)
    for _ in range(rng.randint(1, 4)):
        at, end = sorted(rng.randrange(len(data) + 1) for _ in range(2))
        end = min(end, at + 20)
        data[at:end] = rng.choice((b'', data[at:end] * 9, bytes(rng.randrange(256) for _ in range(end - at))))
    return bytes(data)


def _garbage(server, rng):
    """Return bytes that are nearly a request, or after a handshake nearly a frame, or a message."""
    if server.key == 'web_video' or rng.random() < 0.2:
        return _broken(rng, rng.choice(REQUESTS) + b'Host: 127.0.0.1\r\n\r\n')
    operation, opcode = rng.choice(OPERATIONS), rng.choice((TEXT, BINARY))
    message = json.dumps(operation).encode() if opcode == TEXT else cbor2.dumps(operation)
    if rng.random() < 0.5:
        return handshake({}) + _broken(rng, frame(opcode, message))
    return handshake({}) + frame(opcode, _broken(rng, message))


def _is_ended(server, data):
    """Send bytes and the end; wait until the server has closed the connection."""
    with tcpros.connect(server.place, data) as connection:
        with contextlib.suppress(OSError):
            connection.shutdown(socket.SHUT_WR)
        while connection.recv(CHUNK):
            pass
    return True


def garbage(subject, scale, rng):
    """Send broken requests, frames and messages."""
    found = {}
    with attacked(subject, 'web_garbage', found) as servers:
        for server in servers.values():
            for _ in range(scale.count(3000, 60)):
                server.answered(_is_ended, server, _garbage(server, rng))
    return found


def _said(client):
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


def _one_frame():
    yield frame(TEXT, b'', length=LARGE)
    for _ in range(LARGE // CHUNK):
        yield bytes(CHUNK)


def _many_frames():
    yield frame(TEXT, bytes(CHUNK), 0)
    for _ in range(LARGE // CHUNK):
        yield frame(0, bytes(CHUNK), 0)


def _fragments():
    total = LARGE // CHUNK
    for number in range(total):
        yield masked(
            {'op': 'fragment', 'id': 'large', 'num': number, 'total': total, 'data': 'x' * CHUNK})


FLOODS = {'a message of 100 MB': _one_frame, '100 MB in frames': _many_frames, '100 MB in fragments': _fragments}


def _flood(server, make):
    """Return whether a message of 100 MB is answered."""
    client = server.client()
    try:
        with contextlib.suppress(BrokenPipeError, ConnectionResetError):
            for part in make():
                client.socket.sendall(part)
        return _said(client)
    finally:
        client.close()


def floods(subject, scale, rng):
    """Messages of 100 MB, 500 clients at once, connections that stay half open, and clients that read nothing."""
    found = {}
    with attacked(subject, 'web_flood', found) as servers:
        for key in ('rosbridge', 'browser'):
            for name, make in FLOODS.items():
                servers[key].explained(name, _flood, servers[key], make)
        for server in servers.values():
            _half_open(server, scale.count(200, 50), rng)
        for key in ('rosbridge', 'browser'):
            _crowd(servers[key], scale.count(500, 250))
    return found


def _half_open(server, count, rng):
    """Connections that say nothing, or a part of a request or of a frame; a client beside them gets its answer."""
    parts = [b'', b'GET', b'GET / HTTP/1.1\r\nHost: ', handshake({})]
    if server.key != 'web_video':
        parts += [handshake({}) + frame(TEXT, b'x', length=rng.randint(2, LIMIT)),
                  handshake({}) + b'\x81']
    kept = [tcpros.connect(server.place, parts[number % len(parts)]) for number in range(count)]
    server.inputs += count
    server.explained('a request beside half-open connections', _is_served, server)
    for connection in kept:
        connection.close()


def _is_served(server):
    connection = http.client.HTTPConnection(*server.place, timeout=tcpros.DEADLINE)
    with contextlib.closing(connection):
        connection.request('GET', '/')
        return connection.getresponse().status in (200, 404)


def _crowd(server, count):
    """So many clients at once: each is accepted, or refused with 503 and a reason."""
    clients = []
    for _ in range(count):
        server.explained('one client of a crowd', _joined, server, clients)
    server.explained('a limit of clients', lambda: len(clients) < count)
    for client in clients:
        client.close()


def _joined(server, clients):
    try:
        clients.append(server.client())
        return True
    except Ended as ended:
        return ended.code == 503 and 'connected already' in ended.reason


ATTACKS = {
    'web_garbage': (garbage, 'broken requests, frames and messages'),
    'web_flood': (floods, '100 MB messages, half-open connections, 500 clients'),
}


def _figures(name, words):
    yield Figure(f'{words}: inputs', f'{name}_inputs', '', sum)
    yield Figure(f'{words}: never answered', f'{name}_hung', '', sum, NOTHING)
    yield Figure(f'{words}: nodes ended', f'{name}_ended', '', sum, NOTHING)
    yield Figure(f'{words}: deaf afterwards', f'{name}_deaf', '', sum, NOTHING)
    yield Figure(f'{words}: descriptors left', f'{name}_descriptors', '', max, Target('at_most', SPARE))
    yield Figure(f'{words}: threads left', f'{name}_threads', '', max, Target('at_most', SPARE))
    yield Figure(f'{words}: answered without saying why', f'{name}_unexplained', '', sum, NOTHING)
    yield Figure(f'{words}: calls of a client beside lost', f'{name}_witness', '', sum, NOTHING)
    yield Figure(f'{words}: longest time without a pose beside', f'{name}_gap', 's', max, Target('below', GAP))
    yield Figure(f'{words}: most memory', f'{name}_memory', 'MB', max, Target('below', MEMORY))


FIGURES = (*_figures('web_garbage', 'broken bytes'), *_figures('web_flood', 'floods of bytes and clients'))
