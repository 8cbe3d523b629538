"""Processes of a bench: started in sessions of their own, watched against deadlines, ended by pid. No ROS.

Single-threaded. Every `Child` alive is in `Child.alive`, so that `stop_all()` ends them on any way out.
"""

import os
import select
import signal
import subprocess
import time

TAIL_LINES = 15
STOP_STAGES = ((signal.SIGINT, 3.0), (signal.SIGTERM, 2.0), (signal.SIGKILL, 2.0))  # signal, patience [s]
WAYS_OUT = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
POLL = 0.05  # [s]


class BenchError(RuntimeError):
    """Something that was to be measured did not come up, ended early or did not answer; the text says what to do."""


def parent_of(stat):
    """The parent's pid out of the text of /proc/PID/stat; the process's name in it may hold spaces and brackets."""
    return int(stat.rpartition(')')[2].split()[1])


def kilobytes(status, field):
    """Value [kB] of a field such as VmRSS in the text of /proc/PID/status; 0 where it has none (a zombie)."""
    for line in status.splitlines():
        key, _, value = line.partition(':')
        if key == field:
            return int(value.split()[0])
    return 0


def _read(path):
    with open(path, encoding='utf-8', errors='replace') as file:
        return file.read()


def _parents():
    found = {}
    for entry in os.listdir('/proc'):
        if entry.isdigit():
            try:
                found[int(entry)] = parent_of(_read(f'/proc/{entry}/stat'))
            except OSError:
                continue  # ended since it was listed
    return found


def descendants(root, parents):
    """Pid `root` and all below it, in a {pid: parent pid} mapping."""
    tree = [root]
    for pid in tree:
        tree.extend(child for child, parent in parents.items() if parent == pid)
    return tree


def process_tree(pid):
    """Pids of a process and all its descendants now."""
    return descendants(pid, _parents())


def cpu_seconds(pid):
    """User plus system time [s] that a process has used since its start, over all its threads.

    From the process's CPU clock: the quantity of /proc/PID/stat in nanoseconds instead of 10 ms ticks.
    """
    process_clock = ((~pid) << 3) | 2  # CPUCLOCK_SCHED; include/linux/posix-timers.h
    return time.clock_gettime(process_clock)


def tree_cpu(pid):
    """{pid: CPU seconds} of a process and its descendants."""
    used = {}
    for member in process_tree(pid):
        try:
            used[member] = cpu_seconds(member)
        except OSError:
            continue  # ended in between
    return used


def cpu_between(before, after):
    """CPU seconds used between two `tree_cpu` readings; what began in between counts from its start."""
    return sum(seconds - before.get(pid, 0.0) for pid, seconds in after.items())


def tree_memory(pid):
    """(VmRSS, VmHWM) of a process and its descendants together, in MB (1e6 bytes)."""
    totals = [0, 0]
    for member in process_tree(pid):
        try:
            status = _read(f'/proc/{member}/status')
        except OSError:
            continue
        for index, field in enumerate(('VmRSS', 'VmHWM')):
            totals[index] += kilobytes(status, field)
    return tuple(total * 1024 / 1e6 for total in totals)


class Child:
    """A process whose output goes to a file in `folder`; with lines=True its stdout is read by `next_line`.

    Use as a context manager. `name` is what errors call it.
    """

    alive = []

    def __init__(self, name, command, env, folder, lines=False):
        self.name = name
        self._log_path = os.path.join(folder, f'{name.replace(" ", "_")}_{time.monotonic_ns()}.log')
        self._pending = b''
        signal.pthread_sigmask(signal.SIG_BLOCK, WAYS_OUT)  # started and noted, or neither
        try:
            with open(self._log_path, 'wb') as log:
                self.process = subprocess.Popen(
                    command, env=env, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE if lines else log, stderr=log,
                    start_new_session=True, preexec_fn=_default_signals)
            Child.alive.append(self)
        except OSError as error:
            raise BenchError(f'{name} cannot be started: {error}. Check its command: {command}') from error
        finally:
            signal.pthread_sigmask(signal.SIG_UNBLOCK, WAYS_OUT)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.stop()

    @property
    def pid(self):
        return self.process.pid

    def output(self):
        """All that it has written, but for what `next_line` reads."""
        return _read(self._log_path)

    def lines(self):
        """How many lines it has written."""
        return self.output().count('\n')

    def tail(self):
        """The last lines it has written, indented; a remark when there are none."""
        lines = self.output().splitlines()[-TAIL_LINES:]
        return '\n'.join(f'    {line}' for line in lines) or '    (no output)'

    def require_alive(self):
        """Raise BenchError with its last lines when it has ended."""
        code = self.process.poll()
        if code is not None:
            raise BenchError(f'{self.name} ended early with exit code {code}. Its last lines:\n{self.tail()}')

    def next_line(self, deadline, watched=()):
        """The next line of its stdout, at most until `deadline` [s, time.monotonic].

        Raises BenchError when it or one of the `watched` children ends first, or at the deadline.
        """
        begun = time.monotonic()
        while b'\n' not in self._pending:
            for child in watched:
                child.require_alive()
            if select.select([self.process.stdout], [], [], POLL)[0]:
                chunk = os.read(self.process.stdout.fileno(), 1 << 20)
                if not chunk:
                    self._wait(STOP_STAGES[0][1])
                    raise BenchError(self._last_words(f'{self.name} ended without an answer.', watched))
                self._pending += chunk
            elif time.monotonic() > deadline:
                waited = time.monotonic() - begun
                raise BenchError(self._last_words(f'{self.name} gave no answer within {waited:.0f} s.', watched))
        line, _, self._pending = self._pending.partition(b'\n')
        return line.decode()

    def _last_words(self, text, watched):
        for child in (self, *watched):
            text += f'\n  Last lines of {child.name}:\n{child.tail()}'
        return text

    def _wait(self, patience):
        try:
            self.process.wait(patience)
        except subprocess.TimeoutExpired:
            return False
        return True

    def kill(self):
        """End it by SIGKILL, without its descendants' knowing."""
        self.process.kill()
        self.process.wait()
        self.stop()

    def stop(self):
        """End it and its descendants: asked first, killed when it does not listen. Twice is harmless."""
        if self not in Child.alive:
            return
        for sig, patience in STOP_STAGES:
            if self.process.poll() is not None:
                break
            self._signal_group(sig)
            self._wait(patience)
        self._signal_group(signal.SIGKILL)  # what it started and left behind
        if self.process.stdout:
            self.process.stdout.close()
        Child.alive.remove(self)

    def _signal_group(self, sig):
        try:
            os.killpg(self.pid, sig)  # of its own, by start_new_session
        except ProcessLookupError:
            pass


def _default_signals():
    """A shell's background jobs ignore SIGINT and hand that on; nodes are asked to end with it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, WAYS_OUT)


def stop_all():
    """End every child still alive, the youngest first."""
    for child in reversed(list(Child.alive)):
        child.stop()
