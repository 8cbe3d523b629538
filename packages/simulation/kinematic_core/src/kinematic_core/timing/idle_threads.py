"""Find out whether other processes of this machine are idle, that is, all their threads sleep and wait for input.

A simulator in lockstep starts a step only when all work caused by the last step is done. No program has to report that:
Linux shows for every thread whether it sleeps, and for every process how long its threads have run. If each thread
sleeps when it is checked, and none has run from before the first check until after the last one, all of them were
asleep at the same time: a thread that woke another after its check would have run itself.

A lock of one process is released by a thread of it, which must run for that; sockets, pipes and time wake threads from
outside. So once all threads of a process slept, and none has run since, only those outside of a lock need a check.

This misses two cases: a thread that sleeps in wall time (``time.sleep``) counts as idle, because only its program knows
that it will go on; and data that the kernel delays wakes a thread later. On a busy machine, this may be any data,
because the kernel's own threads wait for a core, too: see ``Machine``.
"""
import os
import time
from typing import Dict, Iterable, List

PROC = '/proc'
LOCK = b'futex'  # start of the names of the functions of Linux in which a thread waits for a lock
ASLEEP = b'SIZX'  # states: waiting (also idle), or ended
OF_PROCESS, OF_THREAD = 2, 6  # lowest bits of the number of a clock; see CPUCLOCK_SCHED in Linux
NO_THREADS = 2  # links of the folder of a process's threads, which has one more for each; a file system may not count


class Gone(Exception):
    """A process has ended, or Linux does not show its threads."""


class Machine:
    """All threads of this machine."""

    def __init__(self) -> None:
        try:
            self._load = os.open(f'{PROC}/loadavg', os.O_RDONLY | os.O_CLOEXEC)
        except OSError:
            self._load = -1

    def is_busy(self) -> bool:
        """Return whether another thread than this one, the kernel's included, runs or waits for a core."""
        try:
            return int(os.pread(self._load, 100, 0).split()[3].split(b'/')[0]) > 1
        except (OSError, IndexError, ValueError):  # the system does not tell
            return True


class ProcessThreads:
    """The threads of one process, read through files that stay open."""

    def __init__(self, pid: int, without: Iterable[int] = ()) -> None:
        """``pid``: id of the process; ``without``: ids of threads that do not count, of this process only. Raise Gone.
        """
        self._pid, self._clock = pid, _clock(pid, OF_PROCESS)
        self._without = set(map(str, without))
        self._states: Dict[str, int] = {}  # thread: file descriptor of its stat
        self._clocks: List[int] = []  # of these threads
        self._links = NO_THREADS  # of the folder when the threads were listed
        self._slept = -1  # [ns] for how long all had run when they last slept
        self._wakeable = self._states  # those of them that something outside of the process can wake
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
                return time.clock_gettime_ns(self._clock)
            return sum(map(time.clock_gettime_ns, self._clocks))
        except OSError as error:
            if self._without:  # a thread has ended
                self._links = NO_THREADS
                return 0
            raise Gone(f'{PROC}/{self._pid}: {error}') from None

    def sleeps(self, ran: int = -1) -> bool:
        """Return whether each thread sleeps when it is checked. Raise Gone.

        ``ran`` [ns]: what ``ran`` has just returned, for a process that shares no locks with others. While it does not
        change, no thread has released a lock, so those that wait for one need not be checked again.
        """
        links = os.fstat(self._folder).st_nlink
        if links != self._links or links == NO_THREADS:
            self._list()
            self._links, self._slept = links, -1
        known = ran == self._slept and ran >= 0
        for thread, state in (self._wakeable if known else self._states).items():
            try:
                line = os.pread(state, 100, 0)  # `number (name) state ...`, where the name may contain anything
            except ProcessLookupError:  # this thread has ended
                self._links = NO_THREADS
                return False
            if line[line.rindex(b')') + 2] not in ASLEEP:
                self._states = {thread: state, **self._states}  # check it first the next time
                return False
        if not known:
            self._slept, self._wakeable = ran, self._states
        elif self._wakeable is self._states:
            self._wakeable = {thread: state for thread, state in self._states.items() if not self._waits(thread)}
        return True

    def _waits(self, thread: str) -> bool:
        """Return whether a thread waits for a lock of its process."""
        try:
            file = os.open(f'{thread}/wchan', os.O_RDONLY | os.O_CLOEXEC, dir_fd=self._folder)
        except OSError:
            return False
        with open(file, 'rb') as name:
            return name.read().startswith(LOCK)

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
        self._clocks = [_clock(int(thread), OF_THREAD) for thread in self._states]


def _clock(number: int, kind: int) -> int:
    """Return the clock of the processor time of a process or thread, as pthread_getcpuclockid does."""
    return ~number << 3 | kind
