"""Grades programs, for ./run grade and for a class: repeats attempts until there is a verdict.

Each attempt is a process that grades once (attempt/attempt.py), forked from a process that has imported everything
(warm_start.py). If it crashes, hangs or is killed, the grading is undecided with the reason, and all its processes are
ended.

Threads: create a Supervisor while the process has one thread; ``grade`` may then be called in several at once, and
``stop`` in any.
"""
import contextlib
import dataclasses
import math
import os
import tempfile
import threading
import time
import uuid
from types import ModuleType
from typing import Callable, Container, Dict, Iterable, Iterator, List, NamedTuple, Optional, Set, Tuple, Union

import psutil

from course_grader.formats import report
from course_grader.isolation import sandbox
from course_grader.isolation.sourced import Sourced
from course_grader.rules import random_stimuli, scoring
from course_grader.rules.exercise import Exercise
from course_grader.rules.observation import Observed
from course_grader.supervision.job import MASTER_LOG, RECORD, SIMULATOR_LOG, Attempted, Job
from course_grader.supervision.warm_start import WarmStart
from kinematic_core.timing.recorder import ACTIVE
from plain_support import processes, write_whole

ATTEMPT = 'course_grader.attempt.attempt'  # imported only in the children: it imports ROS
RESULTS = ('result.json', 'junit.xml', 'path.png', 'path.svg', 'output.txt')  # the files of a grading
EXTRA = 120.0  # [s] of wall time for a grading beyond the time of its exercise
PATIENCE = 3.0  # times that limit, for an attempt that is made alone
GRACE = 0.1  # share of the limit before which an attempt has to say itself why it takes so long
BUSY_SHARE = 0.5  # of the wall time: an attempt that takes more processor time is slow by its program; honest: 0.1
STARVED_SHARE = 0.2  # of the wall time: if it waits longer for a core, the machine is slow; at a load of 20: above 1
LOG = 'grader.txt'  # the output of the attempt itself
MAX_KEPT = 1 << 20  # [bytes] of a log that is kept in the results; those of the samples have less than 30 kB
POLL = 0.1  # [s]
STOP_POLL = 1.0  # [s] between two checks whether a process was stopped
MAX_REPEATED = 45.0  # [s] of wall time; a longer attempt is not repeated for a slow machine
BETWEEN_SEEDS = 10_000  # of two starts in a grading; the seeds of gradings are below
INTERRUPTED = 'the grading was interrupted'
Path = Tuple[Tuple[float, float], ...]


class Retry(NamedTuple):
    """A reason to repeat an attempt, once in a grading, if ``applies(attempted)``; ``real_time``: without lockstep.

    ``within`` [s] of wall time since the first attempt began. ``text`` may use {busy} and {reason}. ``alone``: while no
    other attempt runs, and with a longer limit.
    """

    name: str
    applies: Callable[[Attempted], bool]
    real_time: bool
    within: float
    text: str
    alone: bool = False


def _was_slow(got: Attempted) -> bool:
    return got.verdict.outcome == scoring.UNDECIDED and not got.observed.kept_up


RETRIES = (  # the first that applies and was not used yet counts
    Retry('busy', lambda got: got.lockstep and bool(got.busy), True, math.inf,
          '{busy} never sleeps (is there a rate.sleep() in its loop?). Grading again in real time.'),
    Retry('broken', lambda got: got.broken, False, math.inf, 'Grading again, because {reason}', alone=True),
    Retry('slow', _was_slow, False, MAX_REPEATED, 'Grading again, because {reason}'),
    Retry('slow again', _was_slow, True, MAX_REPEATED, 'Grading again, because {reason}'),
    Retry('alone', _was_slow, False, math.inf, 'Grading again, alone and with more time, because {reason}', alone=True),
)


def next_try(got: Attempted, used: Container[str], seconds: float) -> Optional[Retry]:
    """Return the Retry after an attempt, or None if its result stands.

    ``used``: the names of used ones; ``seconds``: wall time since the first attempt began.
    """
    return next((retry for retry in RETRIES
                 if retry.applies(got) and retry.name not in used and seconds < retry.within), None)


def final(got: Attempted, busy: str, again: bool = False) -> Attempted:
    """Return the last attempt with its verdict; ``busy``: the nodes that never slept in an earlier one.

    ``again``: an earlier attempt was broken, too. A program that floods the simulator, or ends or stops the grader,
    fails instead of being undecided.
    """
    if got.broken and again:
        objection = f'the grading broke down while this program ran, each time: {(got.verdict.objections or [""])[0]}'
        return got._replace(verdict=got.verdict._replace(outcome=scoring.FAILED, score=0.0, objections=[objection]))
    if not (busy and got.flooded and got.verdict.outcome == scoring.UNDECIDED):
        return got
    objection = f'{busy} never sleeps, so the simulator gets no time; is there a rate.sleep() in its loop?'
    return got._replace(verdict=got.verdict._replace(outcome=scoring.FAILED, objections=[objection]))


def remove_results(folder: str) -> None:
    _remove(folder, reversed(RESULTS))  # the first says that the others are results, too: see others_of()


def others_of(folder: str) -> List[str]:
    """Return the files that a grading in a folder would replace, and that no grading has written."""
    names = set(os.listdir(folder)) if os.path.isdir(folder) else set()
    return [] if names & {RESULTS[0], LOG} else sorted(names & {*RESULTS, RECORD})


def _remove(folder: str, names: Iterable[str]) -> None:
    for name in names:
        with contextlib.suppress(FileNotFoundError):
            os.remove(os.path.join(folder, name))


def _shorten(folder: str) -> None:
    """Keep only the start of logs, which a program may have filled before it was ended."""
    for name in (LOG, MASTER_LOG, SIMULATOR_LOG):
        path = os.path.join(folder, name)
        with contextlib.suppress(FileNotFoundError):
            if os.path.getsize(path) > MAX_KEPT:
                os.truncate(path, MAX_KEPT)
                with open(path, 'a', encoding='utf-8') as file:
                    file.write(f'\n... only the first {MAX_KEPT >> 20} MB are kept\n')


def undecided(reason: str, broken: bool = False, slow: bool = False) -> Attempted:
    """Return the Attempted of an attempt without a result.

    ``broken``: it failed while the program ran; ``slow``: because the machine was slow.
    """
    return Attempted(scoring.Verdict(scoring.UNDECIDED, 0.0, [], [reason]), Observed(kept_up=not slow), broken=broken)


def _started(job: Job) -> bool:
    """Return whether the simulator of an attempt had started, and its program ran or was about to."""
    path = os.path.join(job.output, RECORD)
    return os.path.exists(path + ACTIVE) or os.path.exists(path)


def _stopped(child: psutil.Process) -> bool:
    """Return whether an attempt or one of its children was stopped, for example by SIGSTOP."""
    with contextlib.suppress(psutil.Error):
        return any(process.status() == psutil.STATUS_STOPPED for process in (child, *child.children()))
    return False


def _starved(child: psutil.Process, seconds: float) -> bool:
    """Return whether an attempt of ``seconds`` [s] was slow because the machine had no core for it.

    Who keeps the cores busy itself, or waits for something else than a core, is not starved.
    """
    ran = waited = 0.0
    for process in processes.tree(child):
        with contextlib.suppress(psutil.Error, OSError):
            times = process.cpu_times()
            ran += times.user + times.system + times.children_user + times.children_system
            waited += sum(wait for _, wait in processes.thread_times(process.pid).values())
    return ran < BUSY_SHARE * seconds and waited > STARVED_SHARE * seconds


class WrongSolution(RuntimeError):
    """The solution of an exercise does not pass it; the text says why."""


class _Gate:
    """Lets attempts run beside each other, or one alone."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._running, self._closed = 0, False

    @contextlib.contextmanager
    def passed(self, alone: bool) -> Iterator[None]:
        """Wait until an attempt may run; while one runs ``alone``, no other does."""
        with self._changed:
            self._changed.wait_for(lambda: not self._closed)
            self._closed = alone
            self._changed.wait_for(lambda: not (alone and self._running))
            self._running += 1
        try:
            yield
        finally:
            with self._changed:
                self._running -= 1
                self._closed = self._closed and not alone
                self._changed.notify_all()


class Supervisor:
    """Grades Jobs; use it in a with statement, after which no process of a grading remains."""

    def __init__(self, attempt: str = ATTEMPT) -> None:
        """``attempt``: the module whose ``run(job)`` returns an Attempted."""
        processes.adopt_orphans()
        self._starter = WarmStart(attempt, _be_an_attempt)
        self._kept = set(psutil.Process().children())
        self._stop = threading.Event()
        self._gate = _Gate()
        self._tried = False  # see Job
        self._solving = threading.Lock()
        self._solutions: Dict[str, Path] = {}

    def grade(self, job: Job, limit: Optional[float] = None, say: Callable[[str], object] = lambda text: None
              ) -> Attempted:
        """Grade a Job and write its results; return the last attempt.

        ``limit`` [s] of wall time, by default that of the exercise and EXTRA, and PATIENCE times as much for an attempt
        that is made alone; ``say(text)`` reports repeats. Raise OSError if the results cannot be written.
        """
        os.makedirs(job.output, exist_ok=True)
        remove_results(job.output)
        exercise, got = self._starts(job, limit, say)
        report.write(job.output, exercise, got.observed, got.verdict, job.command, job.seed,
                     job.isolation.level, got.remarks)
        return got

    def _starts(self, job: Job, limit: Optional[float], say: Callable[[str], object]) -> Tuple[Exercise, Attempted]:
        """Grade from each start of the exercise, until one does not pass; return the worst, with its exercise.

        ``limit`` [s] of wall time is for all together.
        """
        done: List[Tuple[Exercise, Attempted]] = []
        end = math.inf if limit is None else time.monotonic() + limit
        for number in range(job.exercise.starts):
            seed = job.seed + number * BETWEEN_SEEDS
            exercise = random_stimuli.shifted(job.exercise, seed)
            left = None if limit is None else end - time.monotonic()
            try:
                path = self._solution(job._replace(exercise=exercise, seed=seed), left) if exercise.solution else ()
            except WrongSolution as error:
                return exercise, undecided(str(error))
            got = self._grade(job._replace(exercise=exercise, seed=seed, solution=path), left, say)
            if job.exercise.starts > 1:
                got = got._replace(remarks=(*got.remarks, f'start {number + 1} of {job.exercise.starts} counts, the '
                                            'first that does not pass, or the one with the lowest score'))
            done.append((exercise, got))
            if got.verdict.outcome != scoring.PASSED:
                return done[-1]
        return min(done, key=lambda one: one[1].verdict.score)

    def _solution(self, job: Job, limit: Optional[float]) -> Path:
        """Return the path of the exercise's own solution; raise WrongSolution if it does not pass.

        It is graded once for each start, and removed before a program of a student runs.
        """
        exercise = job.exercise
        key = repr((exercise, job.seed))
        with self._solving:
            if key not in self._solutions:
                with tempfile.TemporaryDirectory(prefix='solution_') as folder:
                    os.chmod(folder, 0o711)  # a user without rights may start it, and finds no other name there
                    program, output = os.path.join(folder, f'{uuid.uuid4().hex}.py'), os.path.join(folder, 'results')
                    write_whole(program, exercise.solution.encode())
                    os.mkdir(output)
                    observed = self._grade(job._replace(
                        command=(program,), folder=folder, output=output, packages=None, sourced=Sourced(),
                        isolation=job.isolation._replace(own=())), limit, lambda text: None).observed
                path = tuple(observed.drawn())
                verdict = scoring.decide(exercise, dataclasses.replace(observed, solution=list(path)))
                if verdict.outcome != scoring.PASSED:
                    raise WrongSolution(f'the solution in the exercise file does not pass: {verdict.main_reason()}')
                self._solutions[key] = path
            return self._solutions[key]

    def stop(self) -> None:
        """End all gradings; later calls return at once."""
        self._stop.set()

    def stopped(self) -> bool:
        return self._stop.is_set()

    def _grade(self, job: Job, limit: Optional[float], say: Callable[[str], object]) -> Attempted:
        start, busy, real_time = time.monotonic(), '', job.real_time
        most = job.exercise.time + EXTRA if limit is None else limit
        deadline, alone = start + most, False
        used: Set[str] = set()
        while True:
            with self._gate.passed(alone):
                deadline = time.monotonic() + PATIENCE * most if alone and limit is None else deadline
                got = self._attempt(job, deadline)
            retry = next_try(got, used, time.monotonic() - start)
            if retry is None or limit is not None and time.monotonic() > deadline:
                return final(got, busy, 'broken' in used)
            used.add(retry.name)
            busy, alone = busy or got.busy, retry.alone
            say(retry.text.format(busy=got.busy, reason=(got.verdict.objections or [''])[0]))
            job = job._replace(real_time=real_time or retry.real_time or bool(busy))

    def _attempt(self, job: Job, deadline: float) -> Attempted:
        """Let a child grade once; return its result, or why there is none."""
        start = time.monotonic()
        limit = max(0.0, deadline - start)
        job = job._replace(mark=uuid.uuid4().hex, limit=(1.0 - GRACE) * limit, tried=self._tried)
        _remove(job.output, (RECORD, RECORD + ACTIVE))
        try:
            child, receiver = self._starter.start(job)
        except ChildProcessError as error:
            return undecided(str(error))
        done, polled = False, time.monotonic()
        try:
            while not receiver.poll(POLL):
                if self._stop.is_set():
                    return undecided(INTERRUPTED)
                if time.monotonic() > deadline:
                    slow = _starved(child, time.monotonic() - start)
                    return undecided(f'the grader needed more than {limit:.0f} s and was stopped',
                                     _started(job) and not slow, slow)
                if time.monotonic() > polled + STOP_POLL:
                    polled = time.monotonic()
                    if _stopped(child):
                        return undecided('the grader or the simulator was stopped', _started(job))
            got: Union[Attempted, OSError] = receiver.recv()
            done = True
            self._tried = self._tried or isinstance(got, Attempted) and got.verdict.outcome in scoring.DECIDED
        except EOFError:
            return undecided(f'the grader ended without a result; see {LOG}', _started(job))
        finally:
            receiver.close()
            if not done:  # otherwise it has ended its processes itself
                processes.end(lambda: {child} | processes.related(f'{sandbox.MARK}={job.mark}', child),
                              processes.KILL)
                sandbox.remove_folders(job.output)
            _shorten(job.output)
        if isinstance(got, OSError):
            raise got
        return got

    def close(self) -> None:
        """End all remaining processes; orphans without the mark have become children of this process."""
        self.stop()
        self._starter.close()
        processes.end(lambda: {process for child in set(psutil.Process().children()) - self._kept
                               for process in processes.tree(child)}, processes.KILL)

    def __enter__(self) -> 'Supervisor':
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _be_an_attempt(attempt: ModuleType, job: Job) -> Union[Attempted, OSError]:
    try:
        with open(os.path.join(job.output, LOG), 'wb') as log:
            for stream in (1, 2):
                os.dup2(log.fileno(), stream)
        got: Attempted = attempt.run(job)
        return got
    except OSError as error:
        return error
