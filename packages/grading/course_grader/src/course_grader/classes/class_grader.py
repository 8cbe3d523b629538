"""Grades the submissions of a class, several at a time, through a concurrent.futures.Executor. Without ROS.

On this machine each grading is a Job of the Supervisor, whose attempts are separate processes: no program can affect
another's verdict, or prevent the table of the class. remote.py grades on other machines.

Threads: the executor runs ``task`` in its threads, which share only the Supervisor.
"""
import concurrent.futures
import contextlib
import os
import time
from typing import Any, Callable, Dict, Mapping, NamedTuple, Optional, Sequence, Tuple

from course_grader.classes import graded
from course_grader.classes.graded import Graded
from course_grader.classes.submissions import Submission
from course_grader.formats import report
from course_grader.isolation.confinement import NO_ISOLATION, Isolation
from course_grader.rules import scoring
from course_grader.rules.exercise import Exercise
from course_grader.rules.observation import Observed
from course_grader.rules.scoring import Verdict
from course_grader.supervision.job import Job
from course_grader.supervision.supervisor import INTERRUPTED, Supervisor, remove_results
from plain_support import write_whole


class Work(NamedTuple):
    """A submission to grade: its exercise, the folder for the results, the seed, and what graded.save() stores.

    ``limit`` [s]: longest wall time, by default the Supervisor's; ``path`` of the exercise file and {name: path} of the
    submission's files, for another machine; ``isolation`` on this machine, and the options for it on another one.
    """

    submission: Submission
    exercise: Exercise
    folder: str
    seed: int
    fingerprint: str = ''
    repeat: Tuple[str, ...] = ()
    limit: Optional[float] = None
    path: str = ''
    files: Mapping[str, str] = {}
    isolation: Isolation = NO_ISOLATION
    isolated_by: Tuple[str, ...] = ()


class Answer(NamedTuple):
    """The result of a task: the wall time [s] of the grading, and its files unless they are already in their folder."""

    seconds: float
    files: Mapping[str, bytes] = {}


def by(supervisor: Supervisor) -> Callable[[Work], Answer]:
    """Return the task that grades on this machine."""
    def grade(work: Work) -> Answer:
        start = time.monotonic()
        if supervisor.stopped():
            raise InterruptedError(INTERRUPTED)
        submission = work.submission
        own = [submission.packages] if submission.packages else filter(os.path.isfile, submission.command)
        supervisor.grade(
            Job(work.exercise, tuple(submission.command), os.path.abspath(submission.folder),
                os.path.abspath(work.folder), work.seed, submission.packages,
                isolation=work.isolation._replace(own=tuple(own))), work.limit)
        return Answer(time.monotonic() - start)
    return grade


def grade(works: Sequence[Work], executor: concurrent.futures.Executor, task: Callable[[Any], Answer],
          done: Callable[[Graded], None], stop: Callable[[], object] = lambda: None,
          pack: Callable[[Work], object] = lambda work: work) -> None:
    """Grade all by ``task(pack(work))``; ``done(graded)`` is called for each.

    ``stop()`` ends the running ones if this is interrupted.
    """
    pending: Dict[concurrent.futures.Future[Answer], Work] = {}
    with executor:
        try:
            for work in works:
                pending[_submit(work, executor, task, pack)] = work
            for future in concurrent.futures.as_completed(list(pending)):
                done(_finished(pending.pop(future), future.result))
        except KeyboardInterrupt:
            for future in [future for future in pending if future.done()]:  # they have just ended and count, too
                done(_finished(pending.pop(future), future.result))
            raise
        finally:
            stop()
            for future in pending:
                future.cancel()


def _submit(work: Work, executor: concurrent.futures.Executor, task: Callable[[Any], Answer],
            pack: Callable[[Work], object]) -> 'concurrent.futures.Future[Answer]':
    """Return the future of a grading; it is already done if there is no program to start."""
    done: concurrent.futures.Future[Answer] = concurrent.futures.Future()
    try:
        if work.submission.trouble is None:
            return executor.submit(task, pack(work))
        done.set_result(_without_attempt(work, work.submission.trouble))
    except (OSError, ValueError) as error:
        done.set_exception(error)
    return done


def _finished(work: Work, answer: Callable[[], Answer]) -> Graded:
    """Return the Graded of a task's answer, stored in its folder."""
    start = time.monotonic()
    try:
        os.makedirs(work.folder, exist_ok=True)
        answered = answer()
        for name, content in answered.files.items():
            write_whole(os.path.join(work.folder, os.path.basename(name)), content)
        graded.save(work.folder, work.fingerprint, answered.seconds, work.repeat)
        return graded.load(work.submission, work.folder)
    except InterruptedError as error:
        return graded.undecided(work.submission, work.folder, str(error))
    except Exception as error:  # of any kind, also from another machine: the others are still graded
        with contextlib.suppress(OSError):
            remove_results(work.folder)
        reason = f'the grading failed: {error or type(error).__name__}'
        return graded.undecided(work.submission, work.folder, reason, time.monotonic() - start)


def _without_attempt(work: Work, trouble: str) -> Answer:
    """Write the results of a submission without a program to start; ``trouble``: why."""
    os.makedirs(work.folder, exist_ok=True)
    remove_results(work.folder)
    decided = Verdict(scoring.FAILED, 0.0, [], [trouble])
    report.write(work.folder, work.exercise, Observed(), decided, (), work.seed)
    return Answer(0.0)
