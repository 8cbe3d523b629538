"""Find out whether other processes of this machine are idle, that is, all their threads sleep and wait for input.

A simulator in lockstep starts a step only when all work caused by the last step is done. No program has to report that:
Linux shows for every thread whether it sleeps, and for every process how long its threads have run. If each thread
sleeps when it is checked, and none has run from before the first check until after the last one, all of them were
asleep at the same time: a thread that woke another after its check would have run itself.

This misses two cases: a thread that sleeps in wall time (``time.sleep``) counts as idle, because only its program knows
that it will go on; and data that the kernel delays wakes a thread later. On a busy machine, this may be any data,
because the kernel's own threads wait for a core, too: ask ``Machine`` whether packets are on their way.
"""
import os
import time
from typing import Dict, Iterable

PROC = '/proc'
ASLEEP = b'SIZX'  # states: waiting (also idle), or ended
OF_PROCESS, OF_THREAD = 2, 6  # lowest bits of the number of a clock; see CPUCLOCK_SCHED in Linux
BACKLOG = 11  # column of /proc/net/softnet_stat since Linux 5.10: packets that this core has yet to deliver
STATISTICS = 1 << 16  # [bytes] of that file, at most
NO_THREADS = 2  # links of the folder of a process's threads, which has one more for each; a file system may not count


class Gone(Exception):
    """A process has ended, or Linux does not show its threads."""


class Machine:
    """All threads of this machine."""

    def __init__(self) -> None:
        self._load, self._network = _opened('loadavg'), _opened('net/softnet_stat')

    def is_busy(self) -> bool:
        """Return whether another thread than this one, the kernel's included, runs or waits for a core."""
        try:
            return int(os.pread(self._load, 100, 0).split()[3].split(b'/')[0]) > 1
        except (OSError, IndexError, ValueError):  # the system does not tell
            return True

    def is_delivering(self) -> bool:
        """Return whether the network (also loopback) has packets that have not reached their sockets, as far as Linux
        tells. They wait for a core if the kernel's own thread (ksoftirqd) delivers them.
        """
        try:
            lines = os.pread(self._network, STATISTICS, 0).splitlines()
            return any(int(line.split()[BACKLOG], 16) for line in lines)
        except (OSError, IndexError, ValueError):  # the system does not tell
            return False


class ProcessThreads:
    """The threads of one process, read through files that stay open."""

    def __init__(self, pid: int, without: Iterable[int] = ()) -> None:
        """``pid``: id of the process; ``without``: ids of threads that do not count, of this process only. Raise Gone.
        """
        self._pid = pid
        self._without = set(map(str, without))
        self._states: Dict[str, int] = {}  # thread: file descriptor of its stat
        self._links = NO_THREADS  # of the folder when the threads were listed
        try:
            self._folder = os.open(f'{PROC}/{pid}/task', os.O_RDONLY | os.O_CLOEXEC)
        except OSError as error:
            raise Gone(str(error)) from None

    def close(self) -> None:
        """Close the files."""
        for file in (self._folder, *self._states.values()):
            os.close(file)
        self._states = {}

    def ran(self) -> int:
        """Return for how long [ns] its threads have run; it is exact for those that sleep. Raise Gone."""
        try:
            if not self._without:
                return time.clock_gettime_ns(_clock(self._pid, OF_PROCESS))
            return sum(time.clock_gettime_ns(_clock(int(thread), OF_THREAD)) for thread in self._states)
        except OSError as error:
            if self._without:  # a thread has ended
                self._links = NO_THREADS
                return 0
            raise Gone(f'{PROC}/{self._pid}: {error}') from None

    def sleeps(self) -> bool:
        """Return whether each thread sleeps when it is checked. Raise Gone."""
        links = os.fstat(self._folder).st_nlink
        if links != self._links or links == NO_THREADS:
            self._list()
            self._links = links
        for thread, state in self._states.items():
            try:
                line = os.pread(state, 100, 0)  # `number (name) state ...`, where the name may contain anything
            except ProcessLookupError:  # this thread has ended
                self._links = NO_THREADS
                return False
            if line[line.rindex(b')') + 2] not in ASLEEP:
                self._states = {thread: state, **self._states}  # check it first the next time
                return False
        return True

    def _list(self) -> None:
        """Open the files of new threads, and close those of threads that have ended."""
        try:
            listed = set(os.listdir(self._folder))
        except OSError as error:
            raise Gone(str(error)) from None
        if not listed:
            raise Gone(f'{PROC}/{self._pid}/task is empty')
        threads = listed - self._without
        for thread in set(self._states) - threads:
            os.close(self._states.pop(thread))
        for thread in threads - set(self._states):
            try:
                self._states[thread] = os.open(f'{thread}/stat', os.O_RDONLY | os.O_CLOEXEC, dir_fd=self._folder)
            except (FileNotFoundError, ProcessLookupError):  # this thread has ended
                pass
            except OSError as error:
                raise Gone(str(error)) from None


def _opened(name: str) -> int:
    """Return the descriptor of a file in /proc, -1 if it cannot be read."""
    try:
        return os.open(f'{PROC}/{name}', os.O_RDONLY | os.O_CLOEXEC)
    except OSError:
        return -1


def _clock(number: int, kind: int) -> int:
    """Return the clock of the processor time of a process or thread, as pthread_getcpuclockid does."""
    return ~number << 3 | kind
