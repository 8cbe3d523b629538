"""Incoming connections, read by one thread with deadlines and size limits. No rospy.

A peer that sends nothing, or a byte now and then, costs a file descriptor until its deadline, and never a thread;
nothing waits for it. A complete request is handed over together with its socket.

Threading contract: ``SocketWatch`` calls back in its own thread, where nothing may block; its methods may be called
from any thread.
"""
import collections
import errno
import os
import re
import selectors
import socket
import struct
import threading
import time

BACKLOG = 1024  # connections that may wait to be accepted
CHUNK = 1 << 16  # [bytes] of one recv
TURN = 16  # chunks that are read from one connection before the next connection gets its turn
SWEEP = 1.0  # [s] between two checks of the deadlines
STANDSTILL = 2.0  # [s] counted at most between two checks: a process that was stopped was not waiting
SHARE_TO_DROP = 10  # without free file descriptors, one in this many waiting connections is dropped
RETRY = 0.5  # [s] before the next accept if there was nothing to drop
HEADER_END = b'\r\n\r\n'
HEADER_LIMIT = 1 << 16  # [bytes] of HTTP
_CONTENT_LENGTH = re.compile(rb'^content-length:[ \t]*([^\r\n]*?)[ \t]*\r?$', re.IGNORECASE | re.MULTILINE)
OUT_OF_FILES = errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM


class Refused(Exception):
    """The data of a peer are refused; the text says why."""


class Ended(Exception):
    """The peer has closed the connection, or was too slow."""


class FrameReader:
    """Reads one block of TCPROS, which is 4 bytes of length (little endian) and as many bytes, and nothing after it."""

    def __init__(self, limit):
        """``limit`` [bytes]: a longer block is refused."""
        self._limit, self._size, self._data = limit, None, bytearray()

    def read(self, connection):
        """Return the block without its length; None while it is incomplete. Raises Refused, Ended."""
        for _ in range(TURN):
            data = receive(connection, min(CHUNK, (4 if self._size is None else self._size) - len(self._data)))
            if data is None:
                return None
            self._data += data
            if self._size is None and len(self._data) == 4:
                self._size = struct.unpack('<I', self._data)[0]
                self._data.clear()
                if self._size > self._limit:
                    raise Refused(f'a length of {self._size} bytes; at most {self._limit} are allowed')
            if len(self._data) == self._size:
                return bytes(self._data)
        return None


class HttpReader:
    """Reads one HTTP request with its body, and drops bytes after it, because no XML-RPC client sends any."""

    def __init__(self, limit):
        """``limit`` [bytes]: a longer body is refused."""
        self._limit, self._data, self._end = limit, bytearray(), None

    def read(self, connection):
        """Return the request, head and body; None while it is incomplete. Raises Refused, Ended."""
        for _ in range(TURN):
            data = receive(connection, CHUNK)
            if data is None:
                return None
            self._data += data
            if self._end is None:
                self._end = self._find_end()
            if self._end is not None and len(self._data) >= self._end:
                return bytes(self._data[:self._end])
        return None

    def _find_end(self):
        """Return the number of bytes in the request; None while its head is incomplete."""
        head = self._data.find(HEADER_END)
        if head < 0:
            if len(self._data) > HEADER_LIMIT:
                raise Refused(f'an HTTP header of more than {HEADER_LIMIT} bytes')
            return None
        length = _CONTENT_LENGTH.search(bytes(self._data[:head]))
        text = length[1] if length else b'0'
        if not text.isdigit():
            raise Refused(f'Content-Length is {text[:40]!r}; it must be a number of bytes')
        if len(text) > 20 or int(text) > self._limit:
            raise Refused(f'an HTTP body of {text[:40].decode()} bytes; at most {self._limit} are allowed')
        return head + len(HEADER_END) + int(text)


def receive(connection, size):
    """Return up to ``size`` bytes; None if there are none yet. Raise Ended if the connection was closed."""
    try:
        data = connection.recv(size)
    except (BlockingIOError, InterruptedError, socket.timeout):
        return None
    except OSError as error:
        raise Ended(str(error)) from None
    if not data:
        raise Ended('closed')
    return data


class _Waiting:
    """A connection that is being read: the arguments of SocketWatch.read; ``left`` [s] to the deadline, or None."""

    def __init__(self, reader, left, done, failed):
        self.reader, self.left, self.done, self.failed = reader, left, done, failed


class SocketWatch:
    """One thread that accepts connections and reads from them."""

    def __init__(self, report):
        """``report(kind, text)`` is called in the watch's thread with warnings for the user."""
        self.report = report
        self._selector = selectors.DefaultSelector()
        self._waiting = {}  # socket: _Waiting, the longest waiting first
        self._paused = {}  # listening socket: (when to accept again [s, monotonic], its callback)
        self._commands = collections.deque()
        self._wake_reader, self._wake_writer = os.pipe()
        for descriptor in (self._wake_reader, self._wake_writer):
            os.set_blocking(descriptor, False)
        self._selector.register(self._wake_reader, selectors.EVENT_READ, None)
        self._deadlines, self._swept = 0, 0.0  # connections with a deadline; when they were checked [s, monotonic]
        self._thread = threading.Thread(target=self._run, name='connections', daemon=True)
        self._thread.start()

    def listen(self, listening, accepted):
        """Listen, and call ``accepted(socket, address)`` for each connection; its socket is non-blocking."""
        listening.listen(BACKLOG)
        listening.setblocking(False)
        self._do(lambda: self._selector.register(listening, selectors.EVENT_READ, accepted))

    def close(self, listening):
        """Close a listening socket."""
        def end():
            self._paused.pop(listening, None)
            self._forget(listening)
            listening.close()
        self._do(end)

    def read(self, connection, reader, done, failed, deadline=None):
        """Call ``done(connection, block)`` when ``reader`` has read a block, or ``failed(connection, error)``.

        ``deadline`` [s] counts from now; None: there is none. The callback owns the socket, which is non-blocking.
        """
        def start():
            waiting = _Waiting(reader, deadline, done, failed)
            try:
                self._selector.register(connection, selectors.EVENT_READ, waiting)
            except (OSError, ValueError, KeyError) as error:  # no memory left in the kernel, or closed
                failed(connection, Ended(str(error)))
                return
            if deadline is not None:
                self._swept = self._swept if self._deadlines else time.monotonic()
                self._deadlines += 1
            self._waiting[connection] = waiting
        connection.setblocking(False)
        self._do(start)

    def _do(self, command):
        """Run a command in the watch's thread."""
        if threading.current_thread() is self._thread:
            command()
            return
        self._commands.append(command)
        try:
            os.write(self._wake_writer, b'.')
        except BlockingIOError:  # it has enough to wake up for
            pass

    def _run(self):
        while True:
            try:
                self._turn()
            except Exception as error:  # the thread must live on: without it the node is deaf
                self.report('internal', f'{type(error).__name__} in the thread of connections: {error}')
                time.sleep(RETRY)

    def _turn(self):
        for key, _ in self._selector.select(self._timeout()):
            if key.data is None:
                self._woken()
            elif isinstance(key.data, _Waiting):
                self._readable(key.fileobj, key.data)
            else:
                self._accept(key.fileobj, key.data)
        self._sweep()

    def _timeout(self):
        if self._paused:
            return RETRY
        return SWEEP if self._deadlines else None

    def _woken(self):
        try:
            while os.read(self._wake_reader, CHUNK):
                pass
        except BlockingIOError:
            pass
        while self._commands:
            self._commands.popleft()()

    def _readable(self, connection, waiting):
        if self._waiting.get(connection) is not waiting:
            return  # dropped in this turn
        try:
            block = waiting.reader.read(connection)
        except (Refused, Ended) as error:
            self._forget(connection)
            waiting.failed(connection, error)
            return
        if block is not None:
            self._forget(connection)
            waiting.done(connection, block)

    def _forget(self, connection):
        waiting = self._waiting.pop(connection, None)
        if waiting is not None and waiting.left is not None:
            self._deadlines -= 1
        try:
            self._selector.unregister(connection)
        except (KeyError, ValueError, OSError):
            pass

    def _accept(self, listening, accepted):
        for _ in range(TURN):
            try:
                connection, address = listening.accept()
            except (BlockingIOError, InterruptedError):
                return
            except OSError as error:
                if error.errno in OUT_OF_FILES:
                    self._out_of_files(error, listening, accepted)
                elif error.errno == errno.EBADF:  # another thread has closed it
                    self._forget(listening)
                return  # all other errors, such as ECONNABORTED: the connection had ended before it was accepted
            try:
                connection.setblocking(False)
                accepted(connection, address)
            except OSError:
                connection.close()

    def _out_of_files(self, error, listening, accepted):
        self.report('descriptors', out_of_files_text(error))
        if not self._drop_oldest():
            self._forget(listening)
            self._paused[listening] = time.monotonic() + RETRY, accepted

    def _drop_oldest(self):
        """Drop the connections that have waited longest; return how many."""
        droppable = [connection for connection, waiting in self._waiting.items() if waiting.left is not None]
        dropped = droppable[:-(-len(droppable) // SHARE_TO_DROP)]
        for connection in dropped:
            waiting = self._waiting[connection]
            self._forget(connection)
            waiting.failed(connection, Ended('out of file descriptors'))
        return len(dropped)

    def _sweep(self):
        now = time.monotonic()
        for listening, (due, accepted) in list(self._paused.items()):
            if now >= due:
                del self._paused[listening]
                self._selector.register(listening, selectors.EVENT_READ, accepted)
        if not self._deadlines or now < self._swept + SWEEP:
            return
        passed, self._swept = min(now - self._swept, STANDSTILL), now
        for connection, waiting in list(self._waiting.items()):
            if waiting.left is not None:
                waiting.left -= passed
                if waiting.left <= 0.0:
                    self._forget(connection)
                    waiting.failed(connection, Ended('too slow'))


def out_of_files_text(error):
    """Return the warning about an OSError whose errno is in OUT_OF_FILES."""
    return (f'The node cannot accept connections: {os.strerror(error.errno)}. It drops idle connections; others wait '
            'until some close. To allow more, type before starting the node: ulimit -n 65536')
