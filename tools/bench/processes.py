"""Processes of a bench: started in sessions of their own, watched against deadlines, ended by pid. No ROS.

Single-threaded. Every `Child` alive is in `Child.alive`, so that `stop_all()` ends them on any way out.
"""
import contextlib
import os
import re
import select
import signal
import subprocess
import time

import psutil

from plain_support import processes

TAIL_LINES = 15
POLL = 0.05  # [s]


class BenchError(RuntimeError):
    """The measured program did not start, ended early or did not answer; the text says what to do."""


def tree(pid):
    """Return a process and its present descendants, each a psutil.Process; nothing if it has ended."""
    try:
        return processes.tree(psutil.Process(pid))
    except psutil.NoSuchProcess:
        return []


class Cpu:
    """Counts the CPU time that a process and its descendants use from now on."""

    def __init__(self, pid):
        self._pid, self._before, self._begun = pid, self._now(pid), time.perf_counter()

    @staticmethod
    def _now(pid):
        used = {}
        for member in tree(pid):
            with contextlib.suppress(OSError):  # ended in between
                used[member] = processes.cpu_time(member.pid)
        return used

    def seconds(self):
        """Return the CPU time [s] so far; processes that started in the meantime count from their start."""
        return sum(used - self._before.get(member, 0.0) for member, used in self._now(self._pid).items())

    def percent(self):
        """Return the CPU time so far, in % of a core."""
        return 100.0 * self.seconds() / (time.perf_counter() - self._begun)


def peak_memory(pid):
    """Return the peak resident memory (VmHWM) [bytes], which psutil does not have; 0 for a zombie."""
    with open(f'/proc/{pid}/status', encoding='utf-8', errors='replace') as file:
        found = re.search(r'^VmHWM:\s*(\d+) kB$', file.read(), re.MULTILINE)
    return int(found[1]) * 1024 if found else 0


def tree_memory(pid):
    """Return the resident memory of a process and its descendants, now and at its peak [MB, 1e6 bytes]."""
    now = most = 0
    for member in tree(pid):
        with contextlib.suppress(psutil.Error, OSError):  # ended in between
            now, most = now + member.memory_info().rss, most + peak_memory(member.pid)
    return now / 1e6, most / 1e6


class Child(processes.BackgroundProcess):
    """A process whose output goes to a file in `folder`; with lines=True its stdout is read by `next_line`.

    Use as a context manager. `name` is what errors call it.
    """

    alive = []

    def __init__(self, name, command, env, folder, lines=False, stdin=subprocess.DEVNULL):
        self.name, self._pending = name, b''
        log = os.path.join(folder, f'{name.replace(" ", "_")}_{time.monotonic_ns()}.log')
        signal.pthread_sigmask(signal.SIG_BLOCK, processes.END_SIGNALS)  # started and noted, or neither
        try:
            super().__init__(command, log, env=env, stdin=stdin, preexec_fn=_default_signals,
                             **({'stdout': subprocess.PIPE} if lines else {}))
            Child.alive.append(self)
        except OSError as error:
            raise BenchError(f'{name} cannot be started: {error}. Check its command: {command}') from error
        finally:
            signal.pthread_sigmask(signal.SIG_UNBLOCK, processes.END_SIGNALS)

    def tail(self):
        """Return its last lines, indented, or a remark if there are none."""
        lines = self.output().splitlines()[-TAIL_LINES:]
        return '\n'.join(f'    {line}' for line in lines) or '    (no output)'

    def require_alive(self):
        """Raise BenchError with its last lines if it has ended."""
        code = self.process.poll()
        if code is not None:
            raise BenchError(f'{self.name} ended early with exit code {code}. Its last lines:\n{self.tail()}')

    def next_line(self, deadline, watched=()):
        """Return the next line of its stdout, at most until `deadline` [s, time.monotonic].

        Raise BenchError if it or one of the `watched` children ends first, or at the deadline.
        """
        begun = time.monotonic()
        while b'\n' not in self._pending:
            for child in watched:
                child.require_alive()
            if select.select([self.process.stdout], [], [], POLL)[0]:
                chunk = os.read(self.process.stdout.fileno(), 1 << 20)
                if not chunk:
                    with contextlib.suppress(subprocess.TimeoutExpired):
                        self.process.wait(processes.END_STAGES[0][1])
                    raise BenchError(self._last_words(f'{self.name} ended without an answer.', watched))
                self._pending += chunk
            elif time.monotonic() > deadline:
                waited = time.monotonic() - begun
                raise BenchError(self._last_words(f'{self.name} did not answer within {waited:.0f} s.', watched))
        line, _, self._pending = self._pending.partition(b'\n')
        return line.decode()

    def _last_words(self, text, watched):
        for child in (self, *watched):
            text += f'\n  Last lines of {child.name}:\n{child.tail()}'
        return text

    def stop(self, stages=processes.END_STAGES):
        """End it and its descendants, by force if need be. Twice is harmless."""
        super().stop(stages)
        if self in Child.alive:
            Child.alive.remove(self)


def _default_signals():
    """Do not ignore SIGINT, by which nodes are ended; a background job of a shell would inherit that."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, processes.END_SIGNALS)


def stop_all():
    """End every child that still runs, the youngest first."""
    for child in reversed(list(Child.alive)):
        child.stop()
