"""Messages of one publisher, read in the loop.

Threading contract: everything runs in the loop's thread.
"""
import contextlib

PREFIX = 4  # [B] of a message's length, little-endian
BUFFER_SIZE = 65536  # [B] at first


class Incoming:
    """A TCPROS connection after its handshake."""

    def __init__(self, loop, connection, rest, deliver, ended):
        """Read ``connection`` (a socket, closed at the end) after the bytes ``rest``.

        ``deliver`` gets the bytes of each message; ``ended`` is called once at the end.
        """
        self._loop, self._connection, self._deliver, self._ended = loop, connection, deliver, ended
        self._data, self._filled = bytearray(max(BUFFER_SIZE, 2 * len(rest))), len(rest)
        self._data[:len(rest)] = rest
        connection.setblocking(False)
        loop.add_reader(connection, self._readable)
        self._take()

    def _readable(self):
        try:
            with memoryview(self._data) as view:
                size = self._connection.recv_into(view[self._filled:])
        except BlockingIOError:
            return
        except OSError:
            size = 0
        if not size:
            self._end()
            return
        self._filled += size
        self._take()

    def _take(self):
        begin = 0
        with memoryview(self._data) as view:
            while self._filled - begin >= PREFIX:
                end = begin + PREFIX + int.from_bytes(view[begin:begin + PREFIX], 'little')
                if end > self._filled:
                    break
                self._deliver(bytes(view[begin + PREFIX:end]))
                begin = end
            left = self._filled - begin
            if begin:
                view[:left] = view[begin:self._filled]
        self._filled = left
        if left == len(self._data):
            self._data += bytes(left)

    def _end(self):
        self._loop.remove_reader(self._connection)
        with contextlib.suppress(OSError):
            self._connection.close()
        self._ended()
