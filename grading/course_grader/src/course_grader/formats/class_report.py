"""The tables of a class, students x exercises: as rows, as CSV and as JUnit XML; class_page.py has the pages."""
import csv
import os
import secrets
from typing import Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple

from course_grader.classes.graded import Graded
from course_grader.formats import class_page, harmless, junit, systems
from course_grader.rules import scoring
from plain_support import write_whole

TABLES = 'scores.csv', 'grades.csv', 'index.html', 'junit.xml'
CODES, ANONYMOUS = 'codes.csv', 'anonymous.csv'  # who is who, for the teacher alone; the table without names
PAGES = 'pages'  # folder of the students' pages
FILES = (*TABLES, CODES, ANONYMOUS, PAGES)
COLUMNS = ('student', *systems.COLUMNS[1:])  # of grades.csv
SIGNS = '23456789abcdefghjkmnpqrstuvwxyz'  # of a code: none that looks like another one
CODE = 5  # signs


class Class(NamedTuple):
    """A class and what it got: students and exercises in the order of the table, {exercise: weight}, all gradings.

    An exercise without a weight has the weight 1.
    """

    title: str
    students: Sequence[str]
    exercises: Sequence[str]
    results: Sequence[Graded]
    weights: Mapping[str, float] = {}

    def best(self) -> Dict[Tuple[str, str], Graded]:
        """Return {(student, exercise): the best of the attempts}; one without a verdict is the worst."""
        best: Dict[Tuple[str, str], Graded] = {}
        for graded in self.results:
            place = graded.submission.student, graded.submission.exercise
            if place not in best or _merit(best[place]) < _merit(graded):
                best[place] = graded
        return best


def _merit(graded: Graded) -> Tuple[bool, bool, float]:
    return graded.outcome != scoring.UNDECIDED, graded.outcome == scoring.PASSED, graded.score


def write(folder: str, graded: Class, student_pages: bool = False, anonymous: bool = False) -> List[str]:
    """Write the tables and pages into a folder; return their paths. Raise OSError when that cannot be."""
    rows = cells(graded)
    contents = {name: content for name, content in zip(TABLES, (
        systems.table(rows), as_rows(graded.results), class_page.of_class(graded, rows, folder),
        as_junit(graded.results)))}
    if anonymous:
        codes = _codes(os.path.join(folder, CODES), graded.students)
        contents[CODES] = systems.table([('code', 'student'), *sorted((code, name) for name, code in codes.items())])
        contents[ANONYMOUS] = systems.table([('code', *rows[0][1:]), *sorted([codes[row[0]], *row[1:]]
                                                                              for row in rows[1:])])
    if student_pages:
        for student in graded.students:
            own = [one for one in graded.results if one.submission.student == student]
            contents[os.path.join(PAGES, f'{student}.html')] = class_page.of_student(student, own)
    for name, content in contents.items():
        os.makedirs(os.path.dirname(os.path.join(folder, name)), exist_ok=True)
        write_whole(os.path.join(folder, name), content)
    shown = [name for name in contents if not name.startswith(PAGES + os.sep)] + [PAGES + os.sep] * student_pages
    return [os.path.join(folder, name) for name in shown]


def cells(graded: Class) -> List[List[str]]:
    """Return the table with its headings, as texts: the scores, '' for missing submissions, and the mean.

    The mean is over all exercises by their weights; missing submissions count 0. It is empty if any score is undecided.
    """
    best = graded.best()
    weights = {exercise: graded.weights.get(exercise, 1.0) for exercise in graded.exercises}
    rows = [['student', *graded.exercises, 'mean']]
    for student in graded.students:
        row = {exercise: best.get((student, exercise)) for exercise in graded.exercises}
        known = all(one is None or one.outcome != scoring.UNDECIDED for one in row.values())
        mean = sum(weights[exercise] * one.score for exercise, one in row.items() if one) / sum(weights.values())
        rows.append([student, *map(_cell, row.values()), f'{mean:.1f}' if known else ''])
    return rows


def _cell(graded: Optional[Graded]) -> str:
    if graded is None:
        return ''
    return scoring.UNDECIDED if graded.outcome == scoring.UNDECIDED else f'{graded.score:g}'


def as_rows(results: Sequence[Graded]) -> str:
    """Return CSV with a row for each submission."""
    return systems.table([COLUMNS, *(
        [one.submission.student, one.submission.exercise,
         '' if one.outcome == scoring.UNDECIDED else f'{one.score:g}', one.outcome,
         systems.first_reason(one.verdict), one.isolation] for one in results)])


def as_junit(results: Sequence[Graded]) -> str:
    """Return JUnit XML: a testsuite for each submission."""
    return junit.document([
        junit.Suite(': '.join(filter(None, (one.submission.student, one.submission.exercise, one.submission.attempt))),
                    f'{one.submission.exercise}.{one.submission.student}', one.verdict, one.seconds,
                    one.isolation)
        for one in results])


def _codes(path: str, students: Sequence[str]) -> Dict[str, str]:
    """Return {student: code}: those of an earlier table where there is one, else drawn."""
    known: Dict[str, str] = {}
    if os.path.isfile(path):
        with open(path, encoding='utf-8', newline='') as file:
            known = {row[1]: row[0] for row in csv.reader(file) if len(row) == 2}
    codes: Dict[str, str] = {}
    for student in students:
        code = known.get(harmless.cell(student), '')
        while not code or code in codes.values():
            code = ''.join(secrets.choice(SIGNS) for _ in range(CODE))
        codes[student] = code
    return codes
