"""A WebSocket client on a plain socket: fast enough to measure a server with, and able to break the rules.

No ROS. If the server closes or refuses a connection, ``Ended`` is raised with its code and reason.
"""

import base64
import json
import os
import socket
import struct

TEXT, BINARY, CLOSE, PING, PONG = 1, 2, 8, 9, 10
FINAL = 128


class Ended(ConnectionError):
    """The server closed the connection, or refused it: ``code`` of HTTP or the close frame, None without one."""

    def __init__(self, code, reason):
        super().__init__(f'the server closed the connection: {code} {reason}')
        self.code, self.reason = code, reason


class WebSocket:
    """A connection to the server at ``place`` (host, port), which behaves like a browser."""

    def __init__(self, place, timeout, headers=()):
        """``timeout`` [s] of each wait; ``headers`` (name, value) replace those of the handshake or are added."""
        self.socket = socket.create_connection(place, timeout)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._chunk = memoryview(bytearray(1 << 20))
        self._data = bytearray()
        try:
            self.socket.sendall(handshake({'Host': f'{place[0]}:{place[1]}', **dict(headers)}))
            self._accept()
        except OSError:
            self.close()
            raise

    def _accept(self):
        while b'\r\n\r\n' not in self._data:
            self._read()
        head, _, rest = bytes(self._data).partition(b'\r\n\r\n')
        self._data = bytearray(rest)
        first, *lines = head.decode('latin-1').split('\r\n')
        if first.split()[1] != '101':
            length = next((int(line.split(':')[1]) for line in lines if line.lower().startswith('content-length')), 0)
            while len(self._data) < length:
                self._read()
            raise Ended(int(first.split()[1]), self._data.decode('utf-8', 'replace').strip())

    def _read(self):
        size = self.socket.recv_into(self._chunk)
        if not size:
            raise Ended(None, '')
        self._data += self._chunk[:size]

    def fileno(self):
        """Return the socket's, for select."""
        return self.socket.fileno()

    def send(self, **operation):
        """Send an operation of rosbridge."""
        self.socket.sendall(masked(operation))

    def subscribe(self, topic, kind, **options):
        """Subscribe to a topic."""
        self.send(op='subscribe', topic=topic, type=kind, **options)

    def advertise(self, topic, kind):
        """Advertise a topic."""
        self.send(op='advertise', topic=topic, type=kind)

    def frames(self):
        """Read the available data; yield the payload of each complete frame."""
        self._read()
        begin = 0
        while len(self._data) - begin >= 2:
            opcode, length, head = self._data[begin] & 15, self._data[begin + 1] & 127, 2
            if length >= 126:
                head = 4 if length == 126 else 10
                if len(self._data) - begin < head:
                    break
                length = int.from_bytes(self._data[begin + 2:begin + head], 'big')
            if len(self._data) - begin < head + length:
                break
            payload = bytes(self._data[begin + head:begin + head + length])
            begin += head + length
            if opcode == PING:
                self.socket.sendall(frame(PONG, payload))
            elif opcode in (TEXT, BINARY):
                yield payload
            elif opcode == CLOSE:
                raise Ended(int.from_bytes(payload[:2], 'big') if payload else None, payload[2:].decode())
        del self._data[:begin]

    def close(self):
        """Close the connection without a close frame; twice is harmless."""
        self.socket.close()


def handshake(headers):
    """Return the bytes with which a client asks for a WebSocket."""
    key = base64.b64encode(os.urandom(16)).decode()
    fields = {'Host': 'localhost', 'Upgrade': 'websocket', 'Connection': 'Upgrade', 'Sec-WebSocket-Key': key,
              'Sec-WebSocket-Version': '13', **headers}
    return ('GET / HTTP/1.1\r\n' + ''.join(f'{name}: {value}\r\n' for name, value in fields.items()) + '\r\n').encode()


def masked(operation):
    """Return the frame of an operation."""
    return frame(TEXT, json.dumps(operation, separators=(',', ':')).encode())


def frame(opcode, payload, first=FINAL, length=None):
    """Return a client's frame, whose mask is zero: XOR changes nothing.

    ``first``: the other bits of its first byte; ``length``: the length that it claims, if not the true one.
    """
    length = len(payload) if length is None else length
    if length < 126:
        head = struct.pack('!BB', first | opcode, 128 | length)
    elif length < 1 << 16:
        head = struct.pack('!BBH', first | opcode, 254, length)
    else:
        head = struct.pack('!BBQ', first | opcode, 255, length)
    return head + bytes(4) + payload
