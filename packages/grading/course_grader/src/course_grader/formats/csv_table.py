"""Gradings as CSV. COLUMNS is the list of columns, for one grading and for those of a class."""
import csv
import io
from typing import Callable, Dict, Iterable, NamedTuple, Sequence

from course_grader.formats import harmless
from course_grader.rules import scoring
from course_grader.rules.scoring import Verdict

NOT_GRADED = 'not graded'  # the verdict of what was handed in, and is not a program for an exercise


class Row(NamedTuple):
    """A grading: the command line or the student, the exercise, the verdict, and the level of isolation or ''."""

    name: str
    exercise: str
    verdict: Verdict
    isolation: str = ''


COLUMNS: Dict[str, Callable[[Row], str]] = {  # heading: what returns the cell; the columns after the name
    'exercise': lambda row: row.exercise,
    'score': lambda row: f'{row.verdict.score:g}' if row.verdict.outcome in scoring.DECIDED else '',
    'verdict': lambda row: row.verdict.outcome,
    'reason': lambda row: row.verdict.main_reason(),
    'isolation': lambda row: row.isolation}


def gradings(name: str, rows: Iterable[Row]) -> str:
    """Return CSV with a row for each grading; ``name``: the heading of the first column."""
    return table([[name, *COLUMNS], *([row.name, *(cell(row) for cell in COLUMNS.values())] for row in rows)])


def table(rows: Iterable[Sequence[str]]) -> str:
    """Return a table with its headings as CSV, without formulas."""
    lines = io.StringIO()
    csv.writer(lines, lineterminator='\n').writerows([harmless.cell(value) for value in row] for row in rows)
    return lines.getvalue()
