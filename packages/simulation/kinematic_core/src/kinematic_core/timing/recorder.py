"""Record simulators in CSV files with one row per tick: the events that took effect, and the nodes that caused them.

Columns: ``tick``, ``event`` (several are separated by ``;``, each a name and its values), those of the simulator, and
``callers``, the nodes that caused the events, in the same order.

As with rosbag's .bag.active, a recording has the suffix ACTIVE while it grows, and its final name once it is closed. No
file is ever overwritten: if the name exists, the recording gets the next free one, a_2.csv after a.csv. A row is
written completely or not at all, unless the machine itself crashes.
"""
import contextlib
import csv
import errno
import io
import itertools
import os
from typing import IO, Iterable, Iterator, List, Optional, Tuple, Union

from plain_support import files

Value = Union[float, str]  # of an event; floats are written to the last bit

ACTIVE = '.active'  # suffix of a recording that grows
CLOSED = -1  # instead of a file descriptor


class Recorder:
    """Writes one recording. Not thread-safe: the lock of the world guards it as well.

    ``path``: the name that the recording gets when it is closed. Devices and pipes are written to as they are.
    """

    def __init__(self, path: Union[str, 'os.PathLike[str]'], columns: Iterable[str]) -> None:
        """Start the file; ``columns`` are the names of the simulator's own columns. Raise OSError if that fails."""
        self.path = self._growing = os.path.abspath(path)
        if files.is_special(self.path):
            self._file = os.open(self.path, os.O_WRONLY | os.O_APPEND | os.O_CLOEXEC)  # CLOSED once it is closed
        else:
            self.path, self._growing, self._file = _create(self.path)
        self._size = 0  # [bytes] of whole rows
        self._events: List[Tuple[str, Tuple[Value, ...], str]] = []  # name, values, caller; since the last tick
        self._write(('tick', 'event', *columns, 'callers'))

    def note(self, event: str, *values: Value, caller: str = '') -> None:
        """Note an event for the next tick. Of consecutive commands, only the last counts."""
        if event.rpartition('/')[2] == 'cmd' and self._events and self._events[-1][0] == event:
            self._events.pop()
        self._events.append((event, values, caller))

    def tick(self, number: int, fields: Iterable[object]) -> None:
        """Write the row of a tick with the simulator's fields.

        If it cannot be written, close the recording without it and raise OSError.
        """
        events = ';'.join(' '.join((name, *map(_text, values))) for name, values, _ in self._events)
        callers = ';'.join(caller for _, _, caller in self._events)
        self._events = []
        self._write((number, events, *fields, callers))

    def close(self) -> None:
        """Close the file and give it its final name."""
        if self._file == CLOSED:
            return
        file, self._file = self._file, CLOSED
        with contextlib.suppress(OSError):
            os.close(file)
        for free in () if self._growing == self.path else _names(self.path):
            with contextlib.suppress(OSError):
                try:
                    files.name_new(self._growing, free)
                    self.path = free
                except FileExistsError:  # since the start
                    continue
            break

    def _write(self, row: Iterable[object]) -> None:
        line = io.StringIO()
        csv.writer(line, lineterminator='\n').writerow(row)
        data = line.getvalue().encode('utf-8')
        try:
            written = 0
            while written < len(data):
                written += os.write(self._file, data[written:])
        except OSError as error:
            with contextlib.suppress(OSError):
                os.ftruncate(self._file, self._size)  # half a row
                if not self._size:
                    os.unlink(self._growing)
            self.close()
            raise type(error)(error.errno, error.strerror, self.path) from None
        self._size += len(data)


def open_growing(path: str) -> Optional[IO[str]]:
    """Open a recording for reading, whether it still grows or is closed; return None if there is none yet."""
    for name in (path + ACTIVE, path):  # in this order, a rename in between does not hide it
        with contextlib.suppress(FileNotFoundError):
            return open(name, encoding='utf-8', newline='')
    return None


def _names(path: str) -> Iterator[str]:
    """Yield ``path`` and its numbered variants."""
    stem, extension = os.path.splitext(path)
    yield path
    for number in itertools.count(2):
        yield f'{stem}_{number}{extension}'


def _create(path: str) -> Tuple[str, str, int]:
    """Return (name, name while it grows, file descriptor) of a new file with the next free name."""
    if os.path.isdir(path):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), path)
    names = _names(path)
    while True:
        free = next(names)
        if not os.path.lexists(free):
            with contextlib.suppress(FileExistsError):
                return free, free + ACTIVE, os.open(free + ACTIVE, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND
                                                    | os.O_CLOEXEC, 0o666)


def _text(value: Value) -> str:
    return repr(value) if isinstance(value, float) else str(value)
