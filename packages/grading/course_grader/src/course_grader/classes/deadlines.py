"""Deadlines that a teacher sets, in the file DEADLINES of the output folder, and the points that late programs lose.

When a program was handed in is known from the platform (downloads.py), from MARKS, or from the dates of the files, if
the teacher trusts these. Without ROS.
"""
import datetime
import math
import os
from typing import Dict, List, Mapping, NamedTuple, Sequence, Tuple

from course_grader.classes import marks
from course_grader.classes.graded import DEADLINES, MARKS, Graded
from course_grader.classes.marks import Key, Mark, MarksError
from course_grader.formats import platforms
from course_grader.rules import scoring

REQUIRED, COLUMNS = ('exercise', 'deadline'), ('exercise', 'deadline', 'points_per_day', 'student')
ALL = '*'  # exercises, or students
DAY = 86400.0  # [s]


class Deadline(NamedTuple):
    """A point in time [s since 1970], and the points that each day after it costs that has begun."""

    at: float
    points: float = 0.0


Deadlines = Mapping[Tuple[str, str], Deadline]  # of (student, exercise), either of which may be ALL


def read(folder: str) -> Dict[Tuple[str, str], Deadline]:
    """Return the deadlines, {} without a file; raise MarksError or OSError."""
    found = {}
    for row, where in marks.rows(os.path.join(folder, DEADLINES), REQUIRED, COLUMNS):
        text, points = (row.get(name) or '' for name in ('deadline', 'points_per_day'))
        try:
            at = marks.moment(text)
        except ValueError:
            raise MarksError(f'{where}: the deadline is {text!r}; write date and time, such as 2026-11-20 18:00'
                             ) from None
        lost = marks.number(points or '0')
        if lost is None:
            raise MarksError(f'{where}: points_per_day is {points!r}; it must be a number from 0 to 100')
        found[row.get('student') or ALL, row['exercise'] or ALL] = Deadline(at, lost)
    return found


def of(key: Key, deadlines: Deadlines) -> Deadline:
    """Return the deadline of (student, exercise), at infinity without one; that of a student goes first."""
    student, exercise = key
    keys = (student, exercise), (student, ALL), (ALL, exercise), (ALL, ALL)
    return next((deadlines[key] for key in keys if key in deadlines), Deadline(math.inf))


def apply(results: Sequence[Graded], deadlines: Deadlines, given: Mapping[Key, Mark], now: float
          ) -> Tuple[List[Graded], List[str]]:
    """Return the results with what late programs lose, and notes; ``given``: marks, ``now`` [s since 1970]."""
    if not deadlines:
        return list(results), []
    applied = [_applied(one, of(_key(one), deadlines), given.get(_key(one), Mark()).handed_in, now)
               for one in results]
    unknown = sum(not (one.submission.handed_in or given.get(_key(one), Mark()).handed_in)
                  and math.isfinite(of(_key(one), deadlines).at) for one in results)
    return applied, [f'{unknown} of {len(results)} submissions count as in time, because nothing says when they were '
                     f'handed in: write it into {MARKS}, column handed_in, or take the dates of the files with '
                     '--file-dates'] if unknown else []


def _key(one: Graded) -> Key:
    return one.submission.student, one.submission.exercise


def _applied(one: Graded, deadline: Deadline, by_hand: str, now: float) -> Graded:
    one = one._replace(over=now > deadline.at)
    when = by_hand or one.submission.handed_in
    if not when or math.isinf(deadline.at) or one.outcome not in scoring.DECIDED:
        return one
    late = marks.moment(when) - deadline.at if when != platforms.LATE else 0.0
    if late <= 0.0 and when != platforms.LATE:
        return one
    days = max(1, math.ceil(late / DAY))
    lost = min(one.score, days * deadline.points)
    how = f'{_duration(late)} late, at {when}' if late else 'late, as the platform says, which counts as one day'
    objection = f'handed in {how}; the deadline was {datetime.datetime.fromtimestamp(deadline.at):%Y-%m-%d %H:%M}'
    if lost:
        objection += f': {lost:g} points less than {one.score:g}'
    return one._replace(verdict=one.verdict._replace(score=round(one.score - lost, 1),
                                                     objections=[objection, *one.verdict.objections]))


def _duration(seconds: float) -> str:
    """Return a duration in words, in full minutes, hours or days and hours."""
    days, rest = divmod(int(seconds), int(DAY))
    if days:
        return f'{days} {"day" if days == 1 else "days"} {rest // 3600} h'
    return f'{rest // 3600} h' if rest >= 3600 else f'{max(1, rest // 60)} min'
