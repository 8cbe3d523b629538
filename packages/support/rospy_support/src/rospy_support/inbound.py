"""Read incoming connections in one thread, with deadlines and size limits. No rospy.

The fault: rospy reads in the thread that accepts, so one peer that connects and sends nothing, or sends slowly, or
announces 4 GB, blocks all others. Here such a peer occupies a file descriptor until its deadline, and never a thread.
A second fault: a process without free file descriptors never accepts again; here it does as soon as some are free.

Threading contract: a SocketWatch runs coroutines in its own thread, where nothing may block; its methods may be called
from any thread, but ``read`` only in a coroutine.
"""
import asyncio
import errno
import os
import re
import struct
import threading
from socket import socket as Socket
from typing import Any, Awaitable, Callable, Coroutine, Dict, List

BACKLOG = 1024  # connections that may wait to be accepted
CHUNK = 1 << 16  # [bytes] of one recv
SHARE_TO_DROP = 10  # without free file descriptors, one in this many waiting connections is dropped
RETRY = 0.2  # [s] before the next accept after one that failed
HEADER_END = b'\r\n\r\n'
HEADER_LIMIT = 1 << 16  # [bytes] of an HTTP header
_CONTENT_LENGTH = re.compile(rb'^content-length:[ \t]*([^\r\n]*?)[ \t]*\r?$', re.IGNORECASE | re.MULTILINE)
Serve = Callable[[Socket, Any], Coroutine[Any, Any, None]]  # (connection, address)
OUT_OF_FILES = errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM


class Refused(Exception):
    """The data of a peer are refused; the text says why."""


class Ended(Exception):
    """The peer has closed the connection, or was too slow."""


async def read_block(connection: Socket, limit: int) -> bytes:
    """Read one block of TCPROS, 4 bytes of length (little endian) and as many bytes, and nothing after it.

    Raise Ended, or Refused if it is longer than ``limit`` [bytes].
    """
    size, = struct.unpack('<I', await _read_exactly(connection, 4))
    if size > limit:
        raise Refused(f'a length of {size} bytes; at most {limit} are allowed')
    return await _read_exactly(connection, size)


async def _read_exactly(connection: Socket, size: int) -> bytes:
    data = bytearray()
    while len(data) < size:
        data += await _receive(connection, min(CHUNK, size - len(data)))
    return bytes(data)


async def read_http(connection: Socket, limit: int) -> bytes:
    """Read one HTTP request, head and body; drop bytes after it, because no XML-RPC client sends any.

    Raise Ended, or Refused if its body is longer than ``limit`` [bytes].
    """
    data = bytearray()
    while HEADER_END not in data:
        if len(data) > HEADER_LIMIT:
            raise Refused(f'an HTTP header of more than {HEADER_LIMIT} bytes')
        data += await _receive(connection, CHUNK)
    head = data.index(HEADER_END)
    length = _CONTENT_LENGTH.search(data[:head])
    text = bytes(length[1]) if length else b'0'
    if not text.isdigit():
        raise Refused(f'Content-Length is {text[:40]!r}; it must be a number of bytes')
    if len(text) > 20 or int(text) > limit:
        raise Refused(f'an HTTP body of {text[:40].decode()} bytes; at most {limit} are allowed')
    end = head + len(HEADER_END) + int(text)
    while len(data) < end:
        data += await _receive(connection, CHUNK)
    return bytes(data[:end])


async def _receive(connection: Socket, size: int) -> bytes:
    """Return up to ``size`` bytes."""
    try:
        data = await asyncio.get_running_loop().sock_recv(connection, size)
    except OSError as error:
        raise Ended(str(error)) from None
    if not data:
        raise Ended('closed')
    return data


class SocketWatch:
    """One thread that accepts connections and reads from them.

    ``admits(connection)`` decides whether a connection is served; every one is, unless a process replaces it.
    """

    @staticmethod
    def admits(_connection: Socket) -> bool:
        """Return True."""
        return True

    def __init__(self, report: Callable[[str, str], None]) -> None:
        """``report(kind, text)`` is called in the watch's thread with warnings for the user."""
        self.report = report
        self._loop = asyncio.new_event_loop()
        self._waiting: Dict[Any, None] = {}  # tasks that read with a deadline, the longest waiting first
        threading.Thread(target=self._loop.run_forever, name='connections', daemon=True).start()

    def listen(self, listening: Socket, serve: Serve) -> None:
        """Listen, and run ``serve(socket, address)`` for each connection; its socket is non-blocking."""
        listening.listen(BACKLOG)
        listening.setblocking(False)
        self._loop.call_soon_threadsafe(self._listen, listening, serve)

    def _listen(self, listening: Socket, serve: Serve) -> None:
        if listening.fileno() >= 0:  # else it was closed
            self._loop.add_reader(listening, self._accept, listening, serve)

    def close(self, listening: Socket) -> None:
        """Close a listening socket."""
        def end() -> None:
            self._loop.remove_reader(listening)
            listening.close()
        self._loop.call_soon_threadsafe(end)

    def run(self, coroutine: Coroutine[Any, Any, None]) -> None:
        """Run a coroutine in the watch's thread."""
        self._loop.call_soon_threadsafe(self._loop.create_task, coroutine)

    async def read(self, reading: Awaitable[bytes], deadline: float) -> bytes:
        """Return what ``reading`` returns; raise Ended if that takes longer than ``deadline`` [s].

        The deadline has two halves, so that a process that was suspended (Ctrl-Z, fg) still reads data that arrived
        in the meantime.
        """
        half = deadline / 2.0
        task: Any = asyncio.current_task()
        timers: List[asyncio.TimerHandle] = []
        timers.append(self._loop.call_later(half, lambda: timers.append(self._loop.call_later(half, task.cancel))))
        self._waiting[task] = None
        try:
            return await reading
        except asyncio.CancelledError:
            raise Ended('too slow') from None
        finally:
            timers[-1].cancel()
            del self._waiting[task]

    def _accept(self, listening: Socket, serve: Serve) -> None:
        try:
            connection, address = listening.accept()
        except OSError as error:  # others, such as ECONNABORTED: the connection had ended before it was accepted
            if error.errno in OUT_OF_FILES:
                self.report('descriptors', out_of_files_text(error))
                for task in list(self._waiting)[:-(-len(self._waiting) // SHARE_TO_DROP)]:
                    task.cancel()
                self._loop.remove_reader(listening)
                self._loop.call_later(RETRY, self._listen, listening, serve)
        else:
            if not self.admits(connection):
                connection.close()
                return
            connection.setblocking(False)
            self._loop.create_task(serve(connection, address))


def out_of_files_text(error: OSError) -> str:
    """Return the warning about an OSError whose errno is in OUT_OF_FILES."""
    return (f'The node cannot accept connections: {os.strerror(error.errno or 0)}. It drops idle connections; others '
            'wait until some close. To allow more, type before starting the node: ulimit -n 65536')
