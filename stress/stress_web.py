"""Bad input for the web servers: frames, operations, floods, connections, and requests of pages.

Each is answered by a status, a code of HTTP or a close code that says why, and a client beside it notices nothing.
"""

import base64
import contextlib
import functools
import http.client
import json
import os
import socket
import threading
import time
import zlib

import cbor2

from figures import Figure, Target
from rosbridge_core.operations import OPERATIONS
from rostest_support import tcpros
from rostest_support.websocket_client import (
    BINARY,
    CLOSE,
    FINAL,
    PING,
    TEXT,
    Ended,
    WebSocket,
    frame,
    handshake,
    masked,
)
from trial import NOTHING, Attack, Trial, losses, running, until

HERE = '127.0.0.1'
LIMIT = 10_000_000  # [B] of a message, by default
LARGE = 100 * 10 ** 6  # [B]
CHUNK = 1 << 20  # [B]
GAP = 1.0  # [s] in which a client beside it gets no pose
MEMORY = 400.0  # [MB]
ANY_CODE = 1000  # the least code of a close frame
WRONG = None, True, 5, -1.5, [], {}, 'x' * 5000
RIGHT = {
    'advertise': {'topic': '/web', 'type': 'std_msgs/String'}, 'unadvertise': {'topic': '/web'},
    'publish': {'topic': '/web', 'msg': {'data': 'x'}}, 'subscribe': {'topic': '/turtle1/pose'},
    'unsubscribe': {'topic': '/web'}, 'call_service': {'service': '/rosapi/get_time', 'args': {}},
    'advertise_service': {'service': '/web', 'type': 'std_srvs/Empty'}, 'unadvertise_service': {'service': '/web'},
    'service_response': {'service': '/web', 'id': 'x', 'values': {}, 'result': True},
    'fragment': {'id': 'x', 'data': '', 'num': 0, 'total': 1}, 'png': {'data': ''}, 'set_level': {'level': 'error'},
    'deadman': {'timeout': 1.0}}
BAD_VALUES = ({'linear': 5}, {'linear': {'x': 'here'}}, {'linear': [1, 2, 3]}, {'speed': 1}, {'angular': {'z': []}},
              {'linear': {'x': {'y': {}}}}, {'linear': {'x': True}})
HOSTS = 'evil.example', 'evil.example:80', '', '127.0.0.1.evil.example', 'localhost.evil.example', '[::1', '\\', 'a b'
ORIGINS = ('http://evil.example', 'https://evil.example', 'null', 'http://localhost.evil.example', 'file://evil',
           'http://127.0.0.1@evil.example', 'ftp://localhost', 'chrome-extension://abcdef', 'javascript:')
BAD_NAMES = ('a b', '1', '-', 'a//b', '/', 'a/', '~', '~x', 'x' * 5000, 'a\nb', 'a\0b', '\u00fc', '\U0001f422', '{}',
             '$(x)', '../..', 'a.b', '%s%n', ' ', '"', "';--", 'a:=b')
SECRET = b'root:'  # how /etc/passwd begins
UP = '..', '%2e%2e', '%2e.', '..%2f', '%252e%252e', '..%c0%af', '..\\', '..%5c', '..%00', '....//'
METHODS = 'POST', 'PUT', 'DELETE', 'PATCH', 'OPTIONS', 'TRACE', 'CONNECT', 'BREW'
QUERIES = ('', 'topic=', 'topic=../../etc/passwd', 'topic=/image&type=vp9', 'topic=/image&type=../x', 'topic=%00',
           'topic=/image&quality=0', 'topic=/image&quality=x', 'topic=/image&width=-5', 'topic=/image&width=99999',
           'topic=/image&height=1e9', f'topic={"x" * 5000}%20', 'topic=/image&width=%d9%a1', 'topic=%ff', 'topic=/a b')


class Server:
    """A web server under attack: where it listens, and its Trial."""

    def __init__(self, node):
        self.node = node
        self.key = node.kind.key
        port = until(lambda: _parameter(node, 'actual_port'), f'the port of {self.key}')
        self.place = HERE, port
        self.trial = Trial(node)
        self.unexplained = []

    def explained(self, attack, call, *arguments, **keywords):
        """Count an input; ``call(...)`` returns whether the answer says why."""
        if not self.trial.answered(functools.partial(call, *arguments, **keywords)):
            self.unexplained.append(attack)

    def client(self, headers=()):
        """Return a connected client."""
        return WebSocket(self.place, tcpros.DEADLINE, headers)


def _parameter(node, name):
    code, _, value = node.master.getParam(tcpros.CALLER, f'{node.kind.node}/{name}')
    return value if code == 1 else None


class Witness:
    """A client of the rosbridge server that gets a turtle's poses: what others do must not disturb it."""

    def __init__(self, server):
        self._socket = server.client()
        self.stamps, self.answers, self.lost = [], 0, 0
        self._socket.subscribe('/turtle1/pose', 'turtlesim/Pose')
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()
        until(lambda: self.stamps, 'a pose at the client beside')

    def _run(self):
        try:
            while True:
                for received in self._socket.frames():
                    if b'"publish"' in received:
                        self.stamps.append(time.monotonic())
                    else:
                        self.answers += 1
        except OSError:
            self.lost = 1

    def ask(self):
        """Return whether a call of it is answered."""
        answers = self.answers
        with contextlib.suppress(OSError):
            self._socket.send(op='call_service', service='/rosapi/get_time')
        end = time.monotonic() + tcpros.DEADLINE
        while self.answers == answers and not self.lost and time.monotonic() < end:
            time.sleep(0.01)
        return self.answers > answers

    def samples(self, name):
        """Stop; return the problems that were noticed."""
        unanswered = 0 if self.ask() else 1
        lost = self.lost
        with contextlib.suppress(OSError):
            self._socket.socket.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self._socket.close()
        gap = max((later - earlier for earlier, later in zip(self.stamps, self.stamps[1:])), default=tcpros.DEADLINE)
        return {f'{name}_witness': [lost + unanswered], f'{name}_gap': [gap]}


@contextlib.contextmanager
def attacked(subject, name, found, *keys):
    """Yield the Servers of these kinds of nodes beside a Witness; put losses into ``found``."""
    with running(subject, 'turtlesim', 'rosbridge', *keys) as nodes:
        servers = {key: Server(nodes[key]) for key in dict.fromkeys(('rosbridge', *keys))}
        witness = Witness(servers['rosbridge'])
        yield servers
        parts = [witness.samples(name)]
        for server in servers.values():
            parts += [server.trial.samples(name), {f'{name}_unexplained': [len(server.unexplained)],
                                                   f'{name}_memory': [server.node.peak_memory()]}]
            for attack in sorted(set(server.unexplained)):
                print(f'    {server.key} did not say why: {attack}', flush=True)
        for part in parts:
            for key, values in part.items():
                found.setdefault(key, []).extend(values)


# --------------------------------------------------------------------------------------------------------- frames


def _unmasked(rng):
    return bytes((FINAL | TEXT, 5)) + b'hello'


def _bytes(rng, count):
    return bytes(rng.randrange(256) for _ in range(count))


FRAMES = {  # what breaks the rules of a WebSocket
    'a frame without a mask': _unmasked,
    'a reserved bit': lambda rng: frame(TEXT, b'{}', FINAL | rng.choice((16, 32, 64))),
    'an unknown opcode': lambda rng: frame(rng.choice((3, 4, 5, 6, 7, 11, 12, 15)), b'x'),
    'a long ping': lambda rng: frame(PING, b'x' * rng.randint(126, 9999)),
    'a ping in parts': lambda rng: frame(PING, b'x', 0),
    'a continuation of nothing': lambda rng: frame(0, b'x'),
    'a text within a text': lambda rng: frame(TEXT, b'{', 0) + frame(TEXT, b'}'),
    'too long': lambda rng: frame(TEXT, b'x', length=rng.choice((LIMIT + 1, 2 ** 31, 2 ** 63 - 1))),
    'the highest bit of a length': lambda rng: frame(TEXT, b'x', length=2 ** 63 + 5),
    'no UTF-8': lambda rng: frame(TEXT, rng.choice((b'\xff', b'"\xed\xa0\x80"', b'\xc3'))),
    'a close frame with a wrong code': lambda rng: frame(CLOSE, rng.choice(
        (0, 999, 1005, 1006, 1015, 65535)).to_bytes(2, 'big')),
    'no JSON': lambda rng: frame(TEXT, rng.choice((b'', b'nonsense', b'{"op":', b'{} {}', b'\0'))),
    'no CBOR': lambda rng: frame(BINARY, rng.choice((b'', b'\xff', b'\x9b' + b'\x7f' * 8, b'\xd8\x1c',
                                                                       b'\x9b' + (2 ** 40).to_bytes(8, 'big')))),
    'random bytes as a message': lambda rng: frame(BINARY, b'\xff' + _bytes(rng, rng.randint(0, 99))),
}


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


def _break(server, make, rng):
    """Return whether a connection with bad bytes is answered."""
    client = server.client()
    try:
        with contextlib.suppress(BrokenPipeError, ConnectionResetError):
            client.socket.sendall(make(rng))
        return _said(client)
    finally:
        client.close()


# --------------------------------------------------------------------------------------------------------- operations


def _wrong_type(rng):
    """Return an operation with a field of a wrong type, or without a field that it needs."""
    name = rng.choice(sorted(RIGHT))
    operation = {'op': name, **RIGHT[name]}
    field = rng.choice([field for field in OPERATIONS[name] if field.required or field.name in ('msg', 'args')])
    wrong = [value for value in WRONG if not isinstance(value, field.types) or
             isinstance(value, bool) and bool not in field.types]
    if field.required and rng.random() < 0.2:
        del operation[field.name]
    else:
        operation[field.name] = rng.choice(wrong)
    return json.dumps(operation)


def _deep(rng):
    depth = rng.choice((500, 5000, 1000000))
    return rng.choice((
        '[' * depth, '{"a":' * depth, '[' * depth + ']' * depth,
        '{"op":"publish","topic":"/turtle1/cmd_vel","msg":{"linear":' + '{"x":' * depth + '0' + '}' * depth + '}}',
        '{"op":"call_service","service":"/spawn","args":' + '[' * depth + ']' * depth + '}', b'\x81' * depth))


def _png_bomb(_):
    """A PNG that is small, and very large once it is decompressed."""
    side = 30000
    header = side.to_bytes(4, 'big') * 2 + bytes((8, 2, 0, 0, 0))
    data = zlib.compress(bytes(10 ** 6))

    def chunk(kind, body):
        return len(body).to_bytes(4, 'big') + kind + body + zlib.crc32(kind + body).to_bytes(4, 'big')
    image = b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', header) + chunk(b'IDAT', data) + chunk(b'IEND', b'')
    return json.dumps({'op': 'png', 'data': base64.b64encode(image).decode()})


def _nested_fragments(_):
    text = '{"op":"fly"}'
    for _ in range(5):
        text = json.dumps({'op': 'fragment', 'id': 'x', 'num': 0, 'total': 1, 'data': text})
    return text


MESSAGES = {  # that the server must refuse, but keep the client
    'a wrong type': _wrong_type,
    'an unknown operation': lambda rng: json.dumps({'op': rng.choice((
        'fly', '', '__init__', '_drain', 'auth', 'x' * 9999, None, 5, [], {}))}),
    'no operation': lambda rng: rng.choice(('5', '"x"', 'null', '[]', '[{"op":"publish"}]', '{}', 'true', '1e999')),
    'deep nesting': _deep,
    'a bad name': lambda rng: json.dumps({'op': 'subscribe', 'topic': rng.choice(BAD_NAMES)}),
    'a bad type': lambda rng: json.dumps({'op': 'advertise', 'topic': '/web', 'type': rng.choice((
        'x', 'a/b', '../x/y', 'os/path', 'std_msgs', 'std_msgs/', '/String', 'std_msgs/String/x', 'rospy/Time'))}),
    'bad values': lambda rng: json.dumps(
        {'op': 'publish', 'topic': '/turtle1/cmd_vel', 'msg': rng.choice(BAD_VALUES)}),
    'a bad call': lambda rng: json.dumps({'op': 'call_service', **rng.choice((
        {'service': '/nobody'}, {'service': '/spawn', 'args': {'x': 'here'}}, {'service': '/spawn', 'args': [1, 2]},
        {'service': '/kill', 'args': {'name': 'nobody'}}, {'service': '/rosapi/set_param', 'args': {'value': ''}},
        {'service': '/rosapi/topic_type', 'args': {'topic': 5}}))}),
    'a bad fragment': lambda rng: json.dumps({'op': 'fragment', 'id': 'x', 'data': '', 'num': rng.choice((
        -1, 5, 10 ** 9)), 'total': rng.choice((1, 2, 5))}),
    'fragments in fragments': _nested_fragments,
    'a PNG bomb': _png_bomb,
    'a number of 100,000 digits': lambda rng: '1' * 100000,
    'CBOR that is not an operation': lambda rng: rng.choice((
        cbor2.dumps(5), cbor2.dumps([]), cbor2.dumps({1: 2}), b'\xc1\xfb' + b'\xff' * 8, b'\xd8\x23\x61(', b'\xf7',
        b'\xc5\x82\x1a\xff\xff\xff\xff\x01')),
}


def sockets(subject, scale, rng):
    """Frames that break the rules, and operations that cannot be done."""
    found = {}
    with attacked(subject, 'web_socket', found, 'browser') as servers:
        for server in servers.values():
            for _ in range(scale.count(100, 2)):
                for name, make in FRAMES.items():
                    server.explained(name, _break, server, make, rng)
            client = server.client()
            for _ in range(scale.count(300, 3)):
                for name, make in MESSAGES.items():
                    server.explained(name, _refused, client, make(rng))
            client.send(op='call_service', service='/rosapi/get_time', id='last')
            server.explained('a right call after them', _answered, client, 'last')
            client.close()
    return found


def _refused(client, message):
    """Return whether a message is answered with an error."""
    data = message if isinstance(message, bytes) else message.encode()
    client.socket.sendall(frame(BINARY if isinstance(message, bytes) else TEXT, data))
    return _said(client)


def _answered(client, name):
    while True:
        for received in client.frames():
            answer = json.loads(received)
            if answer.get('id') == name:
                return answer['result']


# --------------------------------------------------------------------------------------------------------- floods


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
    with attacked(subject, 'web_flood', found, 'browser', 'web_video') as servers:
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
    kept = []
    for number in range(count):
        kept.append(tcpros.connect(server.place, parts[number % len(parts)]))
    server.trial.inputs += count
    server.explained('a request beside half-open connections', _is_refused, server, '/', (200, 404))
    for connection in kept:
        connection.close()


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


# --------------------------------------------------------------------------------------------------------- requests


def _ask(server, path, method='GET', headers=()):
    """Return (status, text) of a request whose parts are sent as they are."""
    fields = {'Host': f'{HERE}:{server.place[1]}', 'Connection': 'close', **dict(headers)}
    request = f'{method} {path} HTTP/1.1\r\n' + ''.join(f'{name}: {value}\r\n' for name, value in fields.items())
    with tcpros.connect(server.place, f'{request}\r\n'.encode()) as connection:
        response = http.client.HTTPResponse(connection, method=method)
        response.begin()
        return response.status, response.read()


def _is_refused(server, path, statuses=(400, 403, 404, 405), said=True, **request):
    status, text = _ask(server, path, **request)
    return status in statuses and SECRET not in text and (bool(text.strip()) or not said)


def _bad_http(rng):
    """Return bytes that are not HTTP, or a request with a wrong method, length or body."""
    length = rng.choice(('-1', 'x', '0', '5', '99999999', str(2 ** 63)))
    body = rng.choice((b'<methodCall>', b'\xff\xfe\0', b'<!DOCTYPE x [<!ENTITY a "b">]><x>&a;</x>', b'{}'))
    method = rng.choice((b'POST', b'GET', b'PUT', b'DELETE', b'\0\0', b'POST' * 500))
    return method + f' / HTTP/1.1\r\nHost: x\r\nContent-Length: {length}\r\n\r\n'.encode() + body


def requests(subject, scale, rng):
    """Foreign pages and names, paths out of the folder, wrong queries and methods, and no HTTP at all."""
    found = {}
    with attacked(subject, 'web_http', found, 'browser', 'web_video') as servers:
        for server in servers.values():
            _foreign(server)
            for path in _paths():
                server.explained(f'path {path[:99]}', _keeps_secret, server, path)
            for method in METHODS:
                server.explained(method, _is_refused, server, '/', method=method, said=False)
            for _ in range(scale.count(500, 20)):
                server.trial.answered(functools.partial(_sent, server, _bad_http(rng)))
        video = servers['web_video']
        for path in ('/stream', '/snapshot', '/stream_viewer'):
            for wanted in QUERIES:
                video.explained(f'{path}?{wanted[:99]}', _is_refused, video, f'{path}?{wanted}'.replace(' ', '%20'))
    return found


def _foreign(server):
    """Pages and WebSockets of foreign sites, and names that are not of this machine."""
    for name, values, statuses in ('Host', HOSTS, (400, 403)), ('Origin', ORIGINS, (403,)):
        for value in values:
            server.explained(f'{name} {value!r}', _is_refused, server, '/', statuses, headers={name: value})
            if server.key != 'web_video':
                server.explained(f'a WebSocket, {name} {value!r}', _is_shut_out, server, {name: value})


def _keeps_secret(server, path):
    return SECRET not in _ask(server, path)[1]


def _paths():
    deep = len(os.path.abspath(__file__).split('/')) + 3
    for up in UP:
        for start in ('/', '/docs/', '/turtles/', '/app/'):
            yield start + f'{up}/' * deep + 'etc/passwd'
    yield from ('//etc/passwd', '/%2fetc/passwd', '/%2e%2e%2fetc%2fpasswd', 'file:///etc/passwd',
                '/turtles//etc/passwd', 'http://evil.example/etc/passwd', '/' + 'x' * 50000, '/%00', '/%ff',
                '/?' + 'a=b&' * 5000)


def _is_shut_out(server, headers):
    try:
        server.client(headers).close()
        return False
    except Ended as ended:
        return ended.code in (400, 403) and bool(ended.reason)


def _sent(server, data):
    """Send bytes and the end; wait for the server's answer or its end."""
    with tcpros.connect(server.place, data) as connection:
        with contextlib.suppress(OSError):
            connection.shutdown(socket.SHUT_WR)
        tcpros.receive(connection, 1)
    return True


ATTACKS = {
    'web_socket': Attack(sockets, 'frames and operations of a WebSocket'),
    'web_flood': Attack(floods, '100 MB messages, half-open connections, 500 clients'),
    'web_http': Attack(requests, 'foreign pages, paths, queries and invalid HTTP'),
}


def _figures(name, words):
    yield from losses(name, words)
    yield Figure(f'{words}: answered without saying why', f'{name}_unexplained', '', sum, NOTHING)
    yield Figure(f'{words}: calls of a client beside lost', f'{name}_witness', '', sum, NOTHING)
    yield Figure(f'{words}: longest time without a pose beside', f'{name}_gap', 's', max, Target('below', GAP))
    yield Figure(f'{words}: most memory', f'{name}_memory', 'MB', max, Target('below', MEMORY))


FIGURES = (*_figures('web_socket', 'frames and operations'), *_figures('web_flood', 'floods of bytes and clients'),
           *_figures('web_http', 'requests of pages'))
