"""Measures who takes the processor time of an attempt, and whether it kept up with real time."""
import os
import time

from course_grader.attempt.forked import POLL
from course_grader.isolation.limits import MANY_BUSY
from course_grader.rules.observation import Problem
from kinematic_core.timing.stall_free_timer import ActiveTimer
from plain_support import processes

HOG_CORES = 1.3  # cores that a program may use while the simulation cannot keep up; a busy loop takes one
UNMEASURED = 1.0  # [s] of processor time that may be older: it is polled from time to time
BUSY_SHARE = 0.5  # of the wall time, of a run that met its limit: the processor time of the program itself
SERVER_SHARE = 0.3  # of the wall time, of a run that met its limit: more processor time of master, simulator and grader
                    # is due to what the program sends them; an honest program's run takes 0.05 of it
LEAST_SHARE = 0.2  # of the wall time, below which a simulator was not kept busy, but got no core
FLOODED_SHARE = 0.5  # busy share of a simulator, of the time for which it has a core; undisturbed 0.05
MAX_STALL = 0.25  # [s] for which the machine may stall in real time
LAG = 0.1  # [s] of simulated time by which a recording may lag


class Load:
    """The processor times of a program and of what serves it, from now on."""

    def __init__(self, student, servers):
        """``servers``: the process ids of master and simulator."""
        self._student, self._pids = student, (*servers, os.getpid())
        self._before = self._spent()

    def _spent(self):
        """Return the processor times [s] of the program, and of master, simulator and grader, and the time [s]."""
        return self._student.cpu(), sum(map(cpu_time, self._pids)), time.monotonic()

    def problem(self, late):
        """Return the Problem of a program that slowed the simulation down; ``late``: whether it met its limit."""
        spent = (after - before for before, after in zip(self._before, self._spent()))
        return hog(*spent, late, self._student.greedy())


def hogs(used, wall):
    """Return whether a program that used ``used`` [s] of processor time in ``wall`` [s] slowed the simulation down."""
    return used > HOG_CORES * wall + UNMEASURED


def hog(used, served, wall, late, greedy=False):
    """Return the Problem of a program that used ``used`` [s] of processor time in ``wall`` [s], or None.

    ``served`` [s]: processor time of master, simulator and grader; ``late``: whether the run met its limit;
    ``greedy``: the program kept many threads busy.
    """
    if hogs(used, wall) or late and used > BUSY_SHARE * wall:
        return Problem(f'the program took {used:.0f} s of processor time in {wall:.0f} s, so that nothing was left for '
                       'the simulation')
    if greedy:
        return Problem(f'the program kept {MANY_BUSY} or more threads busy at a time: since then it got only what the '
                       'rest of the machine leaves')
    if late and served > SERVER_SHARE * wall:
        return Problem(f'the program kept master, simulator and grader busy, for {served:.0f} s of processor time in '
                       f'{wall:.0f} s, by what it sends, prints, calls or registers')
    return None


class Flood:
    """Tells whether a simulator is busy with what the nodes send it, from now on."""

    def __init__(self, pid):
        self._pid, self._began = pid, time.monotonic()
        self._threads, self._used = processes.thread_times(pid), cpu_time(pid)

    def seen(self):
        """Return whether it was busy for most of the time for which it had a core."""
        return flooded(self._threads, processes.thread_times(self._pid), time.monotonic() - self._began,
                       cpu_time(self._pid) - self._used)


def flooded(before, after, seconds, used=0.0):
    """Return whether a process was busy for most of the time for which it had a core, between two thread_times().

    ``used`` [s]: its processor time including ended threads; each call of a service creates one.
    """
    spent = [[now - then for now, then in zip(times, before.get(thread, (0.0, 0.0)))]
             for thread, times in after.items()]
    if spent:
        _, waited = max(spent)  # its main thread, or the busiest one
        spent.append([used, waited])
    return any(ran > max(FLOODED_SHARE * (seconds - waited), LEAST_SHARE * seconds) for ran, waited in spent)


class Pace:
    """The wall time of a run, from now on, and its longest gap."""

    def __init__(self):
        self._watching, self._stood = ActiveTimer(), 0.0

    def elapsed(self):
        """Return the wall time [s], without that for which the machine stood."""
        return self._watching.elapsed()

    def sleep(self):
        """Let time pass in real time until the next look."""
        before = time.monotonic()
        time.sleep(POLL)
        self._stood = max(self._stood, time.monotonic() - before - POLL)

    def is_behind(self, now, slowest):
        """Return whether ``now`` [s] of simulated time are less than the ``slowest`` pace makes of the wall time."""
        return self._watching.elapsed() + self._watching.lost - now > (1.0 - slowest) * now + LAG

    def stalled(self):
        """Return whether the machine stood for so long that commands were late."""
        return self._stood > MAX_STALL


def cpu_time(pid):
    """Return the processor time [s] of a process, 0 if it has ended."""
    try:
        return processes.cpu_time(pid)
    except OSError:
        return 0.0
