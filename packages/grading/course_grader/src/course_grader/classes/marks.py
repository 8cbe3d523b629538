"""Scores and comments that a teacher gives by hand, in the file MARKS of the output folder, which no run changes.

Without ROS.
"""
import csv
import datetime
import difflib
import os
from typing import Collection, Dict, Iterator, List, NamedTuple, Optional, Sequence, Tuple

from course_grader.classes.graded import MARKS, Graded
from course_grader.formats import platforms
from course_grader.rules import scoring

REQUIRED = 'student', 'exercise'
COLUMNS = (*REQUIRED, 'score', 'verdict', 'comment', 'handed_in')
PASSES = 80.0  # score that passes, unless the mark says the verdict
Key = Tuple[str, str]  # student, exercise


class MarksError(ValueError):
    """The file cannot be used; the text says what is wrong, in which line, and what is allowed."""


class Mark(NamedTuple):
    """What is given by hand; None or '': it stays as graded. ``handed_in``: date and time, or LATE."""

    score: Optional[float] = None
    verdict: str = ''
    comment: str = ''
    handed_in: str = ''


def read(folder: str) -> Dict[Key, Mark]:
    """Return {(student, exercise): Mark}, {} without a file; raise MarksError or OSError."""
    return {(row['student'], row['exercise']): _mark(row, where)
            for row, where in rows(os.path.join(folder, MARKS), REQUIRED, COLUMNS)}


def rows(path: str, required: Sequence[str], columns: Sequence[str]) -> Iterator[Tuple[Dict[str, str], str]]:
    """Yield ({column: text}, where it stands) for each row of a table of the teacher, if that exists.

    Raise MarksError or OSError.
    """
    if not os.path.isfile(path):
        return
    try:
        with open(path, encoding='utf-8-sig', newline='') as file:
            reader = csv.DictReader(file, skipinitialspace=True)
            wrong = [name for name in reader.fieldnames or () if name not in columns]
            missing = [name for name in required if name not in (reader.fieldnames or ())]
            if wrong or missing:
                raise MarksError(f'{path}: the first line names the columns, separated by commas, of '
                                 f'{", ".join(columns)}; ' + (f'it has {wrong[0]!r}' if wrong else
                                                              f'it lacks {missing[0]}'))
            for row in reader:
                where = f'{path}, line {reader.line_num}'
                if None in row or None in row.values():
                    raise MarksError(f'{where}: it has another number of columns than the first line; a text with a '
                                     'comma stands in quotation marks')
                yield {name: text.strip() for name, text in row.items()}, where
    except (csv.Error, UnicodeDecodeError) as error:
        raise MarksError(f'{path} is not CSV in UTF-8: {error}') from None


def moment(text: str) -> float:
    """Return date and time in ISO 8601 [s since 1970], by default in the zone of this machine; raise ValueError."""
    if ':' not in text:
        raise ValueError(f'{text!r} has no time')
    try:
        return datetime.datetime.fromisoformat(text).timestamp()
    except (OverflowError, OSError):
        raise ValueError(f'{text!r} is out of range') from None


def number(text: str) -> Optional[float]:
    """Return a number from 0 to 100, or None."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if 0.0 <= value <= 100.0 else None


def _mark(row: Dict[str, str], where: str) -> Mark:
    text, verdict, handed_in = (row.get(name, '') for name in ('score', 'verdict', 'handed_in'))
    score = number(text) if text else None
    if text and score is None:
        raise MarksError(f'{where}: the score is {text!r}; it must be a number from 0 to 100, with a point')
    if verdict not in ('', *scoring.DECIDED):
        raise MarksError(f'{where}: the verdict is {verdict!r}; it must be {" or ".join(scoring.DECIDED)}, or empty')
    try:
        if handed_in not in ('', platforms.LATE):
            moment(handed_in)
    except ValueError:
        raise MarksError(f'{where}: handed_in is {handed_in!r}; write date and time, such as 2026-11-20 18:05, or '
                         f'{platforms.LATE}') from None
    return Mark(score, verdict, row.get('comment', ''), handed_in)


def apply(results: Sequence[Graded], marks: Dict[Key, Mark]) -> Tuple[List[Graded], List[str]]:
    """Return the results with the marks, and texts about marks without a submission."""
    given = [_applied(one, marks[key]) if key in marks else one for one in results
             for key in [(one.submission.student, one.submission.exercise)]]
    known = {(one.submission.student, one.submission.exercise) for one in results}
    return given, [f'{MARKS}: {"/".join(key)} has not been handed in{_meant(key, known)}'
                   for key in marks if key not in known]


def _meant(key: Key, known: Collection[Key]) -> str:
    close = difflib.get_close_matches('/'.join(key), ['/'.join(other) for other in known], 1)
    return f'. Did you mean {close[0]}?' if close else ''


def _applied(one: Graded, mark: Mark) -> Graded:
    if mark == Mark(handed_in=mark.handed_in):  # see deadlines.py
        return one
    verdict = one.verdict
    score = verdict.score if mark.score is None else mark.score
    outcome = mark.verdict or verdict.outcome
    if mark.score is not None and not mark.verdict:
        outcome = scoring.PASSED if score >= PASSES else scoring.FAILED
    before = f'{verdict.score:g}' if verdict.outcome in scoring.DECIDED else verdict.outcome
    changed = f'{score:g} of 100 instead of {before}' if mark.score is not None else mark.verdict
    objection = 'by hand: ' + ': '.join(filter(None, (changed, mark.comment)))
    return one._replace(verdict=verdict._replace(outcome=outcome, score=score,
                                                 objections=[objection, *verdict.objections]))
