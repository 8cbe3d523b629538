"""Finding and ending processes that were started by somebody else's program, however they try to remain. Linux.

Every process inherits the environment, so a mark in it is found in all that a program starts; and this process becomes
the parent of those whose own parent ends (PR_SET_CHILD_SUBREAPER, prctl(2)), so that even what clears its environment
and detaches still descends from here.
"""
import contextlib
import ctypes
import glob
import os
import signal
import time
from typing import Any, Callable, Collection, Iterable, Set, Tuple

PR_SET_CHILD_SUBREAPER = 36
END_STAGES = ((signal.SIGINT, 3.0), (signal.SIGTERM, 1.0), (signal.SIGKILL, 2.0))  # signal, patience [s]
END_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
POLL = 0.02  # [s]


def adopt_orphans() -> None:
    """Become the parent of all descendants whose own parent ends."""
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def make_interruptible() -> None:
    """Let all usual ways to end this process raise KeyboardInterrupt, once: the way out is not interrupted again."""
    def interrupt(_number: int, _frame: Any) -> None:
        for sign in END_SIGNALS:
            signal.signal(sign, signal.SIG_IGN)
        raise KeyboardInterrupt
    for sign in END_SIGNALS:
        signal.signal(sign, interrupt)


def guard(clean_up: Callable[[], None]) -> Tuple[int, Callable[[], None]]:
    """Fork a guardian that calls ``clean_up()`` should this process be killed, by whatever signal.

    Return (its process id, a function that takes it off duty and must be called in the end). To be called while this
    process has one thread.
    """
    watched, held = os.pipe()
    guardian = os.fork()
    if not guardian:
        try:
            os.setsid()
            for sign in END_SIGNALS:
                signal.signal(sign, signal.SIG_IGN)
            os.close(held)
            if not os.read(watched, 1):  # the other end was closed by nobody but the kernel
                clean_up()
        finally:
            os._exit(0)
    os.close(watched)

    def off_duty() -> None:
        os.write(held, b'.')
        os.close(held)
        os.waitpid(guardian, 0)
    return guardian, off_duty


def related(mark: str, root: int, kept: Collection[int] = ()) -> Set[int]:
    """Return the ids of the processes with ``mark`` (NAME=VALUE) in their environment, and of all below ``root``.

    Orphans of this process that have ended are put to rest, but for those ``kept``: somebody waits for their exit code.
    """
    below, marked, parents = {root}, set(), {}
    for entry in map(int, filter(str.isdigit, os.listdir('/proc'))):
        if entry == os.getpid():
            continue
        try:
            with open(f'/proc/{entry}/stat', 'rb') as file:
                state, parent = file.read().rsplit(b')', 1)[1].split()[:2]
            if state == b'Z':
                _reap(entry, int(parent), kept)
                continue
            parents[entry] = int(parent)
            with open(f'/proc/{entry}/environ', 'rb') as file:
                if mark.encode() in file.read().split(b'\0'):
                    marked.add(entry)
        except (OSError, IndexError):
            continue  # it has ended, or belongs to somebody else
    while True:
        children = {pid for pid, parent in parents.items() if parent in below} - below
        if not children:
            return marked | below - {root}
        below |= children


def processor_time(pid: int) -> float:
    """Return the processor time [s] that a process has used so far."""
    with open(f'/proc/{pid}/stat', 'rb') as file:
        fields = file.read().rsplit(b')', 1)[1].split()
    return sum(map(int, fields[11:13])) / os.sysconf('SC_CLK_TCK')  # utime and stime, proc(5)


def below(root: int) -> Set[int]:
    """Return the ids of all processes that descend from ``root``."""
    found: Set[int] = set()
    unseen = {root}
    while unseen:
        parent = unseen.pop()
        for path in glob.glob(f'/proc/{parent}/task/*/children'):
            with contextlib.suppress(OSError), open(path, encoding='ascii') as file:
                unseen |= set(map(int, file.read().split())) - found
        found.add(parent)
    return found - {root}


def end(find: Callable[[], Set[int]], stages: Iterable[Tuple[int, float]] = END_STAGES) -> None:
    """End all processes whose ids ``find()`` returns, and those that come up meanwhile; the ``stages`` get rougher."""
    for sign, patience in stages:
        deadline, told = time.monotonic() + patience, set()
        while True:
            alive = find()
            if not alive or time.monotonic() >= deadline:
                break
            for pid in alive - told:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, sign)
            told |= alive
            time.sleep(POLL)


def _reap(pid: int, parent: int, kept: Collection[int]) -> None:
    """Take the exit code of an orphan that became a child of this process: nobody else will."""
    if parent == os.getpid() and pid not in kept:
        with contextlib.suppress(ChildProcessError):
            os.waitpid(pid, os.WNOHANG)
