"""Grades a folder of submissions, several at a time. Without ROS.

Each grading is a Job of the Supervisor, whose attempts are processes of their own, so that no program can spoil
another's verdict, and none can keep the class from its table.

Threading contract: ``grade`` runs one thread for each grading at a time; they share nothing but the Supervisor.
"""
import concurrent.futures
import os
import random
import time
from typing import Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple

from course_grader.classes.submissions import Submission
from course_grader.rules import scoring
from course_grader.rules.exercise import Exercise
from course_grader.rules.scoring import Verdict
from course_grader.supervision.job import Job
from course_grader.supervision.supervisor import INTERRUPTED, Supervisor, remove_results


class Graded(NamedTuple):
    """The grading of one submission: outcome, score 0..100, reasons (texts), wall time [s], folder with the files.

    ``verdict`` has the objections and checks; None: there was no attempt.
    """

    submission: Submission
    outcome: str
    score: float
    reasons: Tuple[str, ...]
    seconds: float
    folder: str
    verdict: Optional[Verdict] = None


def folder_of(submission: Submission, output: str) -> str:
    """Return the folder of the results of a submission."""
    return os.path.join(output, submission.student, submission.exercise)


def interrupted(submission: Submission, output: str) -> Graded:
    """Return the Graded of what was never done."""
    return Graded(submission, scoring.UNDECIDED, 0.0, (INTERRUPTED,), 0.0, folder_of(submission, output))


class ClassGrader:
    """Grades submissions by a Supervisor."""

    def __init__(self, supervisor: Supervisor, exercises: Dict[str, Exercise], output: str,
                 limit: Optional[float] = None, seed: Optional[int] = None) -> None:
        """``exercises``: by name. ``output``: folder of all results.

        ``limit`` [s]: longest wall time of a grading, by default the Supervisor's; ``seed``: of all, by default drawn.
        """
        self._supervisor, self._exercises, self._output = supervisor, exercises, output
        self._limit, self._seed = limit, seed

    def grade(self, found: Sequence[Submission], jobs: int, done: Callable[[Graded], None]) -> List[Graded]:
        """Return the list of Graded of ``found``, at most ``jobs`` at a time; ``done(graded)`` is told of each."""
        results = []
        with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
            try:
                pending = {pool.submit(self._grade, submission) for submission in found}
                for future in concurrent.futures.as_completed(pending):
                    results.append(future.result())
                    done(results[-1])
            finally:
                self._supervisor.stop()
        order = {submission: number for number, submission in enumerate(found)}
        return sorted(results, key=lambda graded: order[graded.submission])

    def _grade(self, submission: Submission) -> Graded:
        start = time.monotonic()
        if self._supervisor.stopped():
            return interrupted(submission, self._output)
        folder = folder_of(submission, self._output)
        try:
            verdict = self._judge(submission, folder)
        except OSError as error:
            verdict = Verdict(scoring.UNDECIDED, 0.0, [], [f'the grading failed: {error}'])
        reasons = [f'{reason.points:g} of {reason.of:g}: asked: {reason.asked}; seen: {reason.seen}'
                   for reason in verdict.reasons]
        hints = [f'hint: {hint}' for hint in verdict.hints]
        return Graded(submission, verdict.outcome, verdict.score, (*hints, *verdict.objections, *reasons),
                      time.monotonic() - start, folder, verdict)

    def _judge(self, submission: Submission, folder: str) -> Verdict:
        """Return the Verdict; raise OSError when the folder cannot be used."""
        os.makedirs(folder, exist_ok=True)
        if submission.trouble:
            remove_results(folder)
            return Verdict(scoring.FAILED, 0.0, [], [submission.trouble])
        seed = random.SystemRandom().randrange(1, 10_000) if self._seed is None else self._seed
        return self._supervisor.grade(
            Job(self._exercises[submission.exercise], tuple(submission.command), os.path.abspath(submission.folder),
                os.path.abspath(folder), seed, submission.packages), self._limit).verdict
