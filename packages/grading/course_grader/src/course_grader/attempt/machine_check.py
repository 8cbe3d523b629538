"""Checks what a grading needs of its machine: open files, disk, memory, and what every program needs.

What the machine lacks is no fault of the program: a MachineError.
"""
import contextlib
import math
import re
import resource
import shutil
import time

from course_grader.attempt.faults import MachineError, ProgramFault
from course_grader.attempt.forked import POLL
from course_grader.isolation import levels, sandbox, trial
from course_grader.isolation.limits import MEGABYTE
from course_grader.rules.observation import Problem
from kinematic_core.timing.stall_free_timer import ActiveTimer

MANY_FILES = 512  # at a time; the samples, master and simulator have up to 60
LEAST_DISK, FULL_DISK = 8 * MEGABYTE, MEGABYTE // 4  # [bytes] free for the recording, which has up to 2 MB, and logs:
                                                     # before a grading, and below which it cannot go on
FULL = 'the disk of {} is full: make room there, or choose another folder with --output'
TRIAL_TIME = 30.0  # [s] of wall time for a program that only imports, which takes 0.5 s
TRACEBACK = 30  # last lines of the output in which an exception is looked for
KILLED = -9, 137  # exit codes of SIGKILL
MODEST_MEMORY = 512.0  # [MB] up to which a program is not the cause if the machine has none left; samples have 150


def allow_files():
    """Let this process and all that it starts open MANY_FILES; raise MachineError if that is not allowed."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    most = math.inf if hard == resource.RLIM_INFINITY else hard
    if most < MANY_FILES:
        raise MachineError(f'a process may open only {most} files here, and a grading needs {MANY_FILES}; ulimit -Hn '
                           'shows the limit, and /etc/security/limits.conf (nofile) sets it')
    if soft != resource.RLIM_INFINITY and soft < MANY_FILES:
        resource.setrlimit(resource.RLIMIT_NOFILE, (MANY_FILES, hard))


def check_space(folder):
    """Raise MachineError if the disk of a folder has no room for a grading."""
    if shutil.disk_usage(folder).free < LEAST_DISK:
        raise MachineError(f'{FULL.format(folder)}. A grading needs {LEAST_DISK / MEGABYTE:.0f} MB')


class MachineCheck:
    """Tells what the machine lacks from what a program has done, by trials: programs of the grader, as its user."""

    def __init__(self, job, box, deadline):
        """``box``: the Sandbox of the program; ``deadline`` [s, monotonic]: the end of the last trial."""
        self._job, self._box, self._deadline = job, box, deadline
        self._kills_before = 0

    def first_trial(self):
        """Start to import what nearly each program imports; return a Student for ``judge``, or None if not needed."""
        return None if self._job.tried or self._box.user is None else self._trial(trial.first_modules())

    def _trial(self, modules, limits=None):
        try:
            return sandbox.Student(self._box, trial.command(modules, limits), lambda: 0.0)
        except (sandbox.CommandError, OSError) as error:
            raise MachineError(f'no program can be started here: {error}') from None

    def judge(self, tried):
        """Raise MachineError if a trial fails."""
        waiting = ActiveTimer()
        while (tried.exit_code() is None and waiting.elapsed() < TRIAL_TIME
               and time.monotonic() <= self._deadline):
            time.sleep(POLL)
        code = tried.exit_code()
        tried.end()
        if code:
            tried.drain()
            raise MachineError(trial.cause(tried.last_output(), self._box.user, self._box.seen()))

    def program_starts(self):
        """Count from now on how many processes the kernel ends because no memory is left."""
        self._kills_before = kills_for_memory()

    def blame(self, student, problem):
        """Raise MachineError if what has ended a program would end every other one here, too."""
        if problem is None or student.exceeded_limit():
            return
        modules, scarce = trial.suspected('\n'.join(
            [problem.text, *(line.text for line in list(student.lines)[-TRACEBACK:])]))
        if modules or scarce:
            student.end()  # what it has taken is free again
            self.judge(self._trial(modules, self._job.isolation.limits if scarce else None))
        if (student.exit_code() in KILLED and kills_for_memory() > self._kills_before
                and student.memory() < MODEST_MEMORY):
            raise MachineError('this machine has no memory left: its kernel ended the program, which used '
                               f'{student.memory():.0f} MB. End other programs, or grade fewer at a time with --jobs')

    def check_disk(self):
        """Raise MachineError if the disk of the results is full, or ProgramFault if the program has filled it."""
        if shutil.disk_usage(self._job.output).free >= FULL_DISK:
            return
        written = self._box.disk_used() if self._job.isolation.level != levels.NAMESPACE else 0.0
        if written * MEGABYTE < LEAST_DISK:
            raise MachineError(FULL.format(self._job.output))
        raise ProgramFault(Problem(f'the program filled the disk: it has written {written:.0f} MB'))


def kills_for_memory():
    """Return how many processes the kernel has ended since it started because no memory was left."""
    with contextlib.suppress(OSError, IndexError, ValueError), open('/proc/vmstat', encoding='ascii') as file:
        return int(re.findall(r'^oom_kill (\d+)$', file.read(), re.MULTILINE)[0])
    return 0
