"""Writes the results of a class: tables as CSV, JUnit XML, and the pages of class_page.py."""
import csv
import os
import secrets
import shutil
from typing import Dict, List, Optional, Sequence

from course_grader.classes import class_page, class_table, similarity
from course_grader.classes.class_table import Class
from course_grader.classes.graded import ANONYMOUS, CODES, PAGES, PAIRS, SIMILAR, TABLES, Graded, name_of_folder
from course_grader.classes.submissions import LeftOut
from course_grader.formats import csv_table, harmless, junit, platforms
from course_grader.formats.csv_table import NOT_GRADED
from course_grader.rules.scoring import Verdict
from plain_support import write_whole

SIGNS = '23456789abcdefghjkmnpqrstuvwxyz'  # of a code, without look-alikes
CODE = 5  # signs


def write(folder: str, graded: Class, student_pages: bool = False, anonymous: bool = False) -> List[str]:
    """Write the tables and pages into a folder; return their paths. Raise OSError if that fails."""
    rows = class_table.cells(graded)
    contents = {name: content for name, content in zip(TABLES, (
        csv_table.table(rows), as_rows(graded.results, graded.left_out), class_page.of_class(graded, folder),
        as_junit(graded.results, graded.left_out)))}
    if anonymous:
        codes = _codes(os.path.join(folder, CODES), graded.students)
        contents[CODES] = csv_table.table([('code', 'student'), *sorted((code, name) for name, code in codes.items())])
        contents[ANONYMOUS] = csv_table.table([('code', *rows[0][1:]), *sorted([codes[row[0]], *row[1:]]
                                                                              for row in rows[1:])])
    for_platform = platforms.table(graded.origin, graded.exercises, class_table.grades(graded))
    if for_platform:
        contents[f'{graded.origin.platform}.csv'] = csv_table.table(for_platform)
    shutil.rmtree(os.path.join(folder, SIMILAR), ignore_errors=True)
    if graded.similar:
        files = similar_files(graded.similar)
        contents[PAIRS] = csv_table.table(similarity.table(graded.similar, list(files)))
        contents.update({name: page for name, page in files.items() if page})
    if student_pages:
        for student in graded.students:
            own = [one for one in graded.results if one.submission.student == student]
            left_out = [one for one in graded.left_out if one.student == student]
            contents[os.path.join(PAGES, f'{name_of_folder(student)}.html')] = class_page.of_student(
                student, own, left_out)
    for name, content in contents.items():
        os.makedirs(os.path.dirname(os.path.join(folder, name)), exist_ok=True)
        write_whole(os.path.join(folder, name), content)
    shown = [name for name in contents if not name.startswith((PAGES + os.sep, SIMILAR + os.sep))]
    if student_pages:
        shown.append(PAGES + os.sep)
    return [os.path.join(folder, name) for name in shown]


def similar_files(found: Sequence[similarity.Pair]) -> Dict[str, Optional[str]]:
    """Return {name: page} for each pair, in their order; None for programs that are too long to be shown."""
    return {f'{SIMILAR}/{number}.html': similarity.side_by_side(pair) for number, pair in enumerate(found, 1)}


def as_rows(results: Sequence[Graded], left_out: Sequence[LeftOut] = ()) -> str:
    """Return CSV with a row for each submission, and for what is not graded."""
    return csv_table.gradings('student', [
        *(csv_table.Row(one.submission.student, one.submission.exercise, one.verdict, one.isolation)
          for one in results),
        *(csv_table.Row(one.student, '', Verdict(NOT_GRADED, 0.0, [], [one.text()])) for one in left_out)])


def as_junit(results: Sequence[Graded], left_out: Sequence[LeftOut] = ()) -> str:
    """Return JUnit XML: a testsuite for each submission, and one for what is not graded."""
    return junit.document([
        junit.Suite(': '.join(filter(None, (one.submission.student, one.submission.exercise, one.submission.attempt))),
                    f'{one.submission.exercise}.{one.submission.student}', one.verdict, one.seconds,
                    one.isolation)
        for one in results], [(one.text(), one.reason) for one in left_out])


def _codes(path: str, students: Sequence[str]) -> Dict[str, str]:
    """Return {student: code}: those of an earlier table, or new random ones."""
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
