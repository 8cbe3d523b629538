"""Find out whether other processes of this machine are idle, that is, all their threads sleep and wait for input.

A simulator in lockstep starts a step only when all work caused by the last step is done. No program has to report that:
Linux shows for every thread whether it sleeps and how long it has run. If each thread sleeps in two checks, and none
has run in between, all of them were asleep at the same time between the two checks.

This misses two cases: a thread that sleeps in wall time (``time.sleep``) counts as idle, because only its program knows
better; and data that the kernel delays (TCP's delayed acknowledgement, up to 40 ms) wakes a thread later.
"""
import os
from typing import Dict, Iterable, Optional, Set, Tuple, Union

PROC = '/proc'
ASLEEP = b'SIZX'  # states: waiting (also idle), or ended


class Gone(Exception):
    """A process has ended, or Linux does not show its threads."""


class ProcessThreads:
    """The threads of one process, read through files that stay open."""

    def __init__(self, pid: Union[int, str], without: Iterable[int] = ()) -> None:
        """``pid``: id of the process, or 'self'; ``without``: ids of threads that do not count."""
        self._folder = f'{PROC}/{pid}/task'
        self._without = set(map(str, without))
        self._files: Dict[str, Tuple[int, int]] = {}  # thread: file descriptors of its stat and schedstat

    def close(self) -> None:
        """Close the files."""
        for files in self._files.values():
            for file in files:
                os.close(file)
        self._files = {}

    def runs(self) -> Optional[Dict[str, int]]:
        """Return {thread: its run time [ns]}; None if one is running or ready to run. Raise Gone."""
        times = {}
        for thread in self.ids() - self._without:
            try:
                stat, schedstat = self._files.get(thread) or self._open(thread)
                line = os.pread(stat, 400, 0)
                state = line.rindex(b')') + 2  # of `number (name) state ...`, where the name may hold anything
                if line[state] not in ASLEEP:
                    return None
                times[thread] = int(os.pread(schedstat, 100, 0).split()[0])
            except ProcessLookupError:  # this thread has ended
                self._forget(thread)
            except (OSError, IndexError) as error:
                if thread in self.ids():
                    raise Gone(f'{self._folder}/{thread} cannot be read: {error}') from None
        return times

    def ids(self) -> Set[str]:
        """Return the ids of all threads, as texts. Raise Gone."""
        try:
            return set(os.listdir(self._folder))
        except OSError as error:
            raise Gone(str(error)) from None

    def _open(self, thread: str) -> Tuple[int, int]:
        files = []
        try:
            for name in ('stat', 'schedstat'):
                files.append(os.open(f'{self._folder}/{thread}/{name}', os.O_RDONLY | os.O_CLOEXEC))
        except OSError:
            for file in files:
                os.close(file)
            raise
        self._files[thread] = files[0], files[1]
        return self._files[thread]

    def _forget(self, thread: str) -> None:
        for file in self._files.pop(thread, ()):
            os.close(file)
