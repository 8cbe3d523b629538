"""Start, find and end processes, including background processes of untrusted programs. Linux, psutil.

A process is a psutil.Process: its number and its start time. Linux reuses numbers, so a signal is sent only to the
process that was found, never to another one that has its number now.

Every process inherits the environment, so a mark in it is found in all processes that a program starts. This process
can also become the parent of orphans (``adopt_orphans``), so that even a process that clears its environment and
detaches is still a descendant.
"""
import contextlib
import ctypes
import glob
import io
import os
import signal
import subprocess
import time
from typing import Any, Callable, Collection, Dict, Iterator, List, Optional, Sequence, Set, Tuple

import psutil

PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36  # of prctl(2), which psutil does not have
Stages = Sequence[Tuple[int, float]]  # (signal, time [s] until the next one), each stronger than the previous one
END_STAGES: Stages = ((signal.SIGINT, 3.0), (signal.SIGTERM, 1.0), (signal.SIGKILL, 2.0))
KILL: Stages = END_STAGES[-1:]
END_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)  # signals with which users and programs end this process
INTERRUPTED = 130  # exit code of a program that Ctrl-C has ended, as in a shell
POLL = 0.02  # [s]
MAX_FINDING = 60.0  # [s] more for SIGKILL while new processes start: to find some thousands takes seconds


def adopt_orphans() -> None:
    """Become the parent of all descendants whose own parent ends."""
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def end_with_parent(number: int = signal.SIGINT, parent: Optional[int] = None) -> None:
    """Send a signal to this process when the thread that started it ends; for Popen's preexec_fn.

    ``parent`` is the number of that thread's process, which may already have ended.
    """
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, number)
    if parent is not None and os.getppid() != parent:
        os.kill(os.getpid(), number)


def make_interruptible() -> None:
    """Let END_SIGNALS raise KeyboardInterrupt once, so that they cannot interrupt the clean-up after it."""
    def interrupt(_number: int, _frame: Any) -> None:
        for number in END_SIGNALS:
            signal.signal(number, signal.SIG_IGN)
        raise KeyboardInterrupt
    for number in END_SIGNALS:
        signal.signal(number, interrupt)


def guard(clean_up: Callable[[], None]) -> Tuple[psutil.Process, Callable[[], None]]:
    """Fork a guardian that calls ``clean_up()`` if this process is killed, by any signal.

    Return the guardian, and a function that dismisses it, which must be called at the end. Call ``guard`` while this
    process has only one thread.
    """
    watched, held = os.pipe()
    guardian = os.fork()
    if not guardian:
        try:
            os.setsid()
            for number in END_SIGNALS:
                signal.signal(number, signal.SIG_IGN)
            os.close(held)
            if not os.read(watched, 1):  # only the kernel can have closed the other end
                clean_up()
        finally:
            os._exit(0)
    os.close(watched)

    def dismiss() -> None:
        os.write(held, b'.')
        os.close(held)
        os.waitpid(guardian, 0)
    return psutil.Process(guardian), dismiss


def tree(root: psutil.Process) -> List[psutil.Process]:
    """Return a process and all its descendants; [] if it has ended and was waited for."""
    try:
        descendants = root.children(recursive=True)
    except psutil.NoSuchProcess:
        return []
    return [root, *descendants] if root.is_running() else []  # psutil 7 raises nothing


def descendant_ids(root: int) -> Set[int]:
    """Return the numbers of all descendants of ``root``, for observation; do not send signals to them.

    It is fast enough for 50 calls per second: among 150 processes it takes 0.4 ms, psutil's children() 12 ms (5.9.4).
    """
    found: Set[int] = set()
    unseen = {root}
    while unseen:
        parent = unseen.pop()
        for path in glob.glob(f'/proc/{parent}/task/*/children'):
            with contextlib.suppress(OSError), open(path, encoding='ascii') as file:
                unseen |= set(map(int, file.read().split())) - found
        found.add(parent)
    return found - {root}


def related(mark: str, root: psutil.Process, kept: Collection[int] = ()) -> Set[psutil.Process]:
    """Return the running processes with ``mark`` (NAME=VALUE) in their environment, and all descendants of ``root``.

    This process is not among them. Its orphans that have ended are reaped, except those whose numbers are in ``kept``,
    because other code waits for their exit codes.
    """
    name, _, value = mark.partition('=')
    below, found = set(tree(root)) - {root}, set()
    for process in _all():
        with contextlib.suppress(psutil.Error), process.oneshot():
            if process.status() == psutil.STATUS_ZOMBIE:
                if process.ppid() == os.getpid() and process.pid not in kept:
                    _reap(process.pid)
            elif process in below or process.environ().get(name) == value:
                found.add(process)
    return found - {psutil.Process()}


def runs(process: psutil.Process) -> bool:
    """Return whether a process is running; a zombie is not, even if its exit code was not collected yet."""
    with contextlib.suppress(psutil.Error):
        return bool(process.is_running() and process.status() != psutil.STATUS_ZOMBIE)
    return False


def group(leader: psutil.Process) -> Set[psutil.Process]:
    """Return the running processes of the process group that ``leader`` started, even if ``leader`` has ended.

    Linux reuses the number of a group only when the group is empty.
    """
    found = set()
    for process in _all():
        with contextlib.suppress(psutil.Error, OSError):
            if os.getpgid(process.pid) == leader.pid and runs(process):
                found.add(process)
                if process.pid == leader.pid and process != leader:
                    return set()
    return found


def end(find: Callable[[], Set[psutil.Process]], stages: Stages = END_STAGES) -> None:
    """End all processes that ``find()`` returns, including those that start in the meantime; a zombie has ended."""
    for number, patience in stages:
        deadline = time.monotonic() + patience
        last = deadline + (MAX_FINDING if number == signal.SIGKILL else 0.0)
        signalled: Set[psutil.Process] = set()
        while True:
            alive = set(filter(runs, find()))
            new = alive - signalled
            for process in new:
                with contextlib.suppress(psutil.Error):
                    process.send_signal(number)  # not sent if another process has the number now
            signalled |= new
            if not alive:
                return
            if time.monotonic() >= (last if new else deadline):
                break
            time.sleep(POLL)  # psutil.wait_procs would collect exit codes that a Popen waits for


def cpu_time(pid: int) -> float:
    """Return user plus system time [s] of all threads of a process since its start; raise OSError if it has ended.

    It comes from the CPU clock of the process: the same as psutil's cpu_times(), in nanoseconds instead of ticks of
    10 ms.
    """
    return time.clock_gettime((~pid) << 3 | 2)  # CPUCLOCK_SCHED; include/linux/posix-timers.h


def thread_times(pid: int) -> Dict[str, Tuple[float, float]]:
    """Return {thread: (run time, time waiting for a core) [s]} of the threads of a process."""
    times = {}
    for path in glob.glob(f'/proc/{pid}/task/*/schedstat'):
        with contextlib.suppress(OSError), open(path, encoding='ascii') as file:
            ran, waited, _ = map(int, file.read().split())
            times[path.split('/')[4]] = ran / 1e9, waited / 1e9
    return times


class BackgroundProcess:
    """A command in the background, with its output in a file. Use it in a with statement."""

    def __init__(self, command: Sequence[str], log: str, own_group: bool = True, **options: Any) -> None:
        """Start the command; raise OSError if that fails. ``options`` are those of subprocess.Popen.

        With ``own_group``, it gets a new session and process group, and all processes in this group end with it.
        Otherwise it is in the group of this process, so that a signal to this group also ends it.
        """
        self.command, self._log, self._own_group = command, log, own_group
        with open(log, 'wb') as file:
            self.process = subprocess.Popen(command, start_new_session=own_group, **{
                'stdin': subprocess.DEVNULL, 'stdout': file, 'stderr': file, **options})
        self._identity = psutil.Process(self.process.pid)

    @property
    def pid(self) -> int:
        return self.process.pid

    def output(self, most: Optional[int] = None) -> str:
        """Return its output so far, or at most the last ``most`` [bytes] of it."""
        with open(self._log, 'rb') as file:
            if most is not None:
                file.seek(max(0, os.fstat(file.fileno()).st_size - most))
            return io.TextIOWrapper(file, encoding='utf-8', errors='replace').read()

    def last_line(self) -> str:
        return (self.output().strip().splitlines() or ['nothing'])[-1]

    def runs(self) -> bool:
        return self.process.poll() is None

    def signal(self, number: int) -> None:
        """Send a signal to it and its group, unless it has ended."""
        if self.runs():  # so it was not waited for yet, and the number is still its own
            (os.killpg if self._own_group else os.kill)(self.process.pid, number)

    def members(self) -> Set[psutil.Process]:
        """Return the running processes of its group, also after it has ended; none without a group of its own."""
        return group(self._identity) if self._own_group else set()

    def stop(self, stages: Stages = END_STAGES) -> None:
        """End it and the rest of its group, at first gently, then by force. A second call does nothing.

        The rest has the same time as it: the program of a wrapper that ends at once may still be writing a file.
        """
        rest: Stages = KILL
        for index, (number, patience) in enumerate(stages):
            deadline = time.monotonic() + patience
            running = self.runs()
            self.signal(number)
            with contextlib.suppress(subprocess.TimeoutExpired):
                self.process.wait(patience)
                if running:  # so the rest was also sent this signal
                    self._wait_for_rest(deadline)
                rest = stages[index + running:] or KILL
                break
        if self._own_group:
            end(self.members, rest)
        if self.process.stdout:
            self.process.stdout.close()

    def _wait_for_rest(self, deadline: float) -> None:
        while self.members() and time.monotonic() < deadline:
            time.sleep(POLL)

    def __enter__(self) -> 'BackgroundProcess':
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()


def _all() -> Iterator[psutil.Process]:
    """Yield all processes, without psutil.process_iter, whose cache is shared by all threads."""
    for pid in psutil.pids():
        with contextlib.suppress(psutil.Error):
            yield psutil.Process(pid)


def _reap(pid: int) -> None:
    """Collect the exit code of an orphan that became a child of this process."""
    with contextlib.suppress(ChildProcessError):
        os.waitpid(pid, os.WNOHANG)
