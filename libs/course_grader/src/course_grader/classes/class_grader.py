"""Grades a folder of submissions, several at a time, each by a grader of its own. Without ROS.

Each grading is one process, so that no program can spoil another's verdict, and none can keep the class from its
table: a grader that crashes, or is not done within its time limit, leaves the outcome 'undecided' with the reason, and
everything that it or the graded program started is ended.

Threading contract: ``grade`` runs one thread for each grading at a time; they share nothing but ``_stop`` and
``_graders``, the latter under the interpreter's lock (single appends and removals).
"""
import concurrent.futures
import contextlib
import json
import os
import signal
import subprocess
import tempfile
import threading
import time
import uuid
from typing import IO, Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple

import psutil

from course_grader.classes.submissions import Submission
from course_grader.formats import exit_codes
from course_grader.rules import scoring
from process_support import processes

MARK = 'TURTLE_ROBOTONT_CLASSROOM'
RESULTS = ('result.json', 'junit.xml', 'path.png', 'output.txt')  # what a grader writes
POLL = 0.1  # [s]
CLEANING = 12.0  # [s] that a grader gets to end what it has started
INTERRUPTED = 'the grading was interrupted'
LAST_LINES = 3  # of a grader that failed, in the reason


class Graded(NamedTuple):
    """The grading of one submission: outcome, score 0..100, reasons (texts), wall time [s], folder with the files."""

    submission: Submission
    outcome: str
    score: float
    reasons: Tuple[str, ...]
    seconds: float
    folder: str


def folder_of(submission: Submission, output: str) -> str:
    """Return the folder of the results of a submission."""
    return os.path.join(output, submission.student, submission.exercise)


def interrupted(submission: Submission, output: str) -> Graded:
    """Return the Graded of what was never done."""
    return Graded(submission, scoring.UNDECIDED, 0.0, (INTERRUPTED,), 0.0, folder_of(submission, output))


class ClassGrader:
    """Grades submissions with ``grader``, a command that takes EXERCISE --output DIR -- COMMAND."""

    def __init__(self, grader: Sequence[str], exercises: Dict[str, str], output: str,
                 limit: Callable[[str], float]) -> None:
        """``exercises``: {name: path}. ``output``: folder of all results. ``limit(name)``: [s] a grading may take."""
        self._grader, self._exercises, self._output, self._limit = list(grader), exercises, output, limit
        self._stop = threading.Event()
        self._graders: List[int] = []  # their process ids
        self._mark = uuid.uuid4().hex
        processes.adopt_orphans()

    def grade(self, found: Sequence[Submission], jobs: int, done: Callable[[Graded], None]) -> List[Graded]:
        """Return the list of Graded of ``found``, at most ``jobs`` at a time; ``done(graded)`` is told of each.

        However this is left, no child of this process remains.
        """
        results = []
        with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
            try:
                pending = {pool.submit(self._grade, submission) for submission in found}
                for future in concurrent.futures.as_completed(pending):
                    results.append(future.result())
                    done(results[-1])
            finally:
                self._stop.set()
                pool.shutdown()
                processes.end(lambda: processes.related(f'{MARK}={self._mark}', psutil.Process()), processes.KILL)
        order = {submission: number for number, submission in enumerate(found)}
        return sorted(results, key=lambda graded: order[graded.submission])

    def _grade(self, submission: Submission) -> Graded:
        start = time.monotonic()
        if self._stop.is_set():
            return interrupted(submission, self._output)
        folder = folder_of(submission, self._output)
        try:
            outcome, score, reasons = self._judge(submission, folder)
        except OSError as error:
            outcome, score, reasons = scoring.UNDECIDED, 0.0, [f'the grading failed: {error}']
        return Graded(submission, outcome, score, tuple(reasons), time.monotonic() - start, folder)

    def _judge(self, submission: Submission, folder: str) -> Tuple[str, float, List[str]]:
        """Return (outcome, score, reasons); raise OSError when the folder cannot be used."""
        os.makedirs(folder, exist_ok=True)
        for name in RESULTS:  # of an earlier time
            with contextlib.suppress(FileNotFoundError):
                os.remove(os.path.join(folder, name))
        if submission.trouble:
            return scoring.FAILED, 0.0, [submission.trouble]
        packages = [f'--packages={submission.packages}'] if submission.packages else []
        command = [*self._grader, *packages, self._exercises[submission.exercise], '--output', os.path.abspath(folder),
                   '--', *submission.command]
        with tempfile.TemporaryFile() as said:
            code = self._run(command, submission.folder, said, self._limit(submission.exercise))
            said.seek(0)
            lines = said.read().decode('utf-8', 'replace').splitlines()
        if code is None:
            why = INTERRUPTED if self._stop.is_set() else \
                f'the grader needed more than {self._limit(submission.exercise):.0f} s and was stopped'
            return scoring.UNDECIDED, 0.0, [why]
        return _result(folder, code, lines)

    def _run(self, command: Sequence[str], folder: str, output: IO[bytes], limit: float) -> Optional[int]:
        """Run a grader; return its exit code, or None when it was ended before it was done."""
        mark = f'{MARK}_GRADING={uuid.uuid4().hex}'
        environment = {**os.environ, MARK: self._mark, **dict([mark.split('=')])}
        grader = subprocess.Popen(command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=output,
                                  stderr=subprocess.STDOUT, start_new_session=True)
        identity = psutil.Process(grader.pid)
        self._graders.append(grader.pid)
        try:
            deadline = time.monotonic() + limit
            while grader.poll() is None and time.monotonic() < deadline and not self._stop.is_set():
                with contextlib.suppress(subprocess.TimeoutExpired):
                    grader.wait(POLL)
            code = grader.poll()
            if code is None:
                grader.send_signal(signal.SIGINT)  # it ends what it has started, and itself
                with contextlib.suppress(subprocess.TimeoutExpired):
                    grader.wait(CLEANING)
            return code
        finally:
            processes.end(lambda: processes.related(mark, identity, self._graders), processes.KILL)
            grader.wait()
            self._graders.remove(grader.pid)


def _result(folder: str, code: int, lines: Sequence[str]) -> Tuple[str, float, List[str]]:
    """Return (outcome, score, reasons) that a grader has left; its exit code must agree."""
    said = '; '.join(line.strip() for line in [line for line in lines if line.strip()][-LAST_LINES:])
    try:
        with open(os.path.join(folder, 'result.json'), encoding='utf-8') as file:
            result = json.load(file)
        if exit_codes.OF_OUTCOME[result['outcome']] == code:
            reasons = result['objections'] + [
                f'{reason["points"]:g} of {reason["of"]:g}: asked: {reason["asked"]}; seen: {reason["seen"]}'
                for reason in result['reasons']]
            return result['outcome'], float(result['score']), reasons
    except (OSError, ValueError, KeyError, TypeError):
        pass
    how = f'by signal {-code}' if code < 0 else f'with exit code {code}'
    return scoring.UNDECIDED, 0.0, [f'the grader ended {how}' + (f': {said}' if said else ' without output')]

