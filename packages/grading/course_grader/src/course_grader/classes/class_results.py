"""Shows, writes and reads the results of a class in their output folder, for --all and --merge: tables, JUnit, pages.

The file CLASS in that folder lists the students and submissions, so that the parts of several machines can be merged.
"""
import argparse
import csv
import errno
import json
import os
import secrets
import shutil
import sys
import tempfile
import time
from typing import Any, Dict, List, Optional, Sequence, Tuple

from course_grader.classes import class_page, class_table, deadlines, marks, similarity
from course_grader.classes.class_table import Class
from course_grader.classes.graded import ANONYMOUS, CLASS, CODES, PAGES, PAIRS, SIMILAR, TABLES, Graded, name_of_folder
from course_grader.classes.submissions import LeftOut
from course_grader.formats import csv_table, exit_codes, harmless, junit, platforms, systems, terminal
from course_grader.formats.csv_table import NOT_GRADED
from course_grader.formats.platforms import Origin
from course_grader.formats.terminal import say
from course_grader.rules import scoring
from course_grader.rules.scoring import Verdict
from plain_support import write_whole

SIGNS = '23456789abcdefghjkmnpqrstuvwxyz'  # of a code, without look-alikes
CODE = 5  # signs
MAX_SIMILAR = 20  # pairs that are printed; all are in a table
OUTPUT = os.path.join('output', 'grades')
PRINTED = {'csv': 'grades.csv', 'junit': 'junit.xml'}  # --format: the file that is printed instead


class ClassError(Exception):
    """A class cannot be graded, or its results cannot be written; the text says why and what to do."""


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument('--output', metavar='DIR', default=OUTPUT, help='folder for the results (default: %(default)s)')
    parser.add_argument('--format', choices=(systems.TEXT, *PRINTED), default=systems.TEXT,
                        help='what is printed: a table for people, or grades.csv or junit.xml and nothing else '
                        '(default: %(default)s)')
    parser.add_argument('--weights', metavar='NAME=N,...', type=_weights, default={},
                        help='how much exercises count in the mean (default: 1 each)')
    parser.add_argument('--best', action='store_true', help='of several attempts of a student the best one counts')
    parser.add_argument('--anonymous', action='store_true', help='also write anonymous.csv, with codes instead of '
                        'names, and codes.csv, which says who is who')
    parser.add_argument('--student-pages', action='store_true',
                        help='also write pages/STUDENT.html, in which no other student is named')


def _weights(text: str) -> Dict[str, float]:
    """Return {exercise: weight} of NAME=N,NAME=N; raise ArgumentTypeError."""
    weights = {}
    for part in text.split(','):
        name, _, number = part.partition('=')
        try:
            weights[name.strip()] = float(number)
        except ValueError:
            weights[name.strip()] = -1.0
        if not 0.0 <= weights[name.strip()] < 1e9:
            raise argparse.ArgumentTypeError(f'{part!r} is not a weight; write NAME=N, such as '
                                             'stop_at_x=2,black_path=0.5')
    return weights


def check_weights(weights: Dict[str, float], exercises: Sequence[str]) -> None:
    """Raise ClassError if weights name other exercises, or all are 0."""
    unknown = sorted(set(weights) - set(exercises))
    if unknown:
        raise ClassError(f'--weights names {", ".join(unknown)}, but the exercises are {", ".join(exercises)}')
    if not any(weights.get(exercise, 1.0) for exercise in exercises):
        raise ClassError('--weights: all exercises have the weight 0; one at least has to count')


def check_output(folder: str) -> None:
    """Raise OSError unless files can be written into a folder, MarksError if its MARKS or DEADLINES are wrong.

    Raise ClassError if it has files that would be replaced, and that are not from an earlier class. Call it before the
    gradings.
    """
    os.makedirs(folder, exist_ok=True)
    others = [name for name in (*TABLES, *platforms.NAMES, CODES, ANONYMOUS, PAIRS, PAGES, SIMILAR)
              if os.path.exists(os.path.join(folder, name))]
    if others and not os.path.exists(os.path.join(folder, CLASS)):
        raise ClassError(f'{folder} has {", ".join(others)}, which this would replace, and no results of a class. '
                         'Choose another folder with --output DIR')
    marks.read(folder)
    deadlines.read(folder)
    with tempfile.TemporaryFile(dir=folder) as file:
        file.write(b'.' * 4096)


def show(options: argparse.Namespace, graded: Class, chosen: Sequence[Any], notes: Sequence[str] = ()) -> int:
    """Print the table and write all files; return the exit code for the ``chosen`` results."""
    quiet = options.format != systems.TEXT
    by_hand, dates = marks.read(options.output), deadlines.read(options.output)
    given, undated = deadlines.apply(graded.results, dates, by_hand, time.time())
    given, unknown = marks.apply(given, by_hand)
    graded, notes = graded._replace(results=given), [*notes, *undated, *map(harmless.printed, unknown)]
    if not quiet:
        for line in (*terminal.table(class_table.cells(graded), terminal.columns()), *notes):
            say(line)
        if graded.left_out:
            say('\n'.join(['Not graded:', *(harmless.printed(f'  {one.text()}') for one in graded.left_out)]))
        if graded.similar:
            say('\n'.join(['Similar programs:', *(harmless.printed(f'  {pair.text()}')
                                                  for pair in graded.similar[:MAX_SIMILAR])]))
    content = {'title': graded.title, 'students': list(graded.students), 'exercises': list(graded.exercises),
               'submissions': [(one.submission.student, one.submission.exercise, one.submission.attempt,
                                one.submission.handed_in)
                               for one in graded.results],
               'left_out': list(graded.left_out), 'platform': graded.origin.platform, 'ids': dict(graded.origin.ids)}
    write_whole(os.path.join(options.output, CLASS), json.dumps(content, indent=2) + '\n')  # first: see check_output()
    paths = write(options.output, graded, options.student_pages, options.anonymous)
    if quiet:
        with open(os.path.join(options.output, PRINTED[options.format]), encoding='utf-8', newline='') as file:
            say(file.read().rstrip('\n'))
    else:
        say(harmless.printed('Results: ' + ', '.join(paths)))
    outcomes = {one.outcome for one in chosen}
    worst = next((outcome for outcome in (scoring.FAILED, scoring.UNDECIDED) if outcome in outcomes), scoring.PASSED)
    return exit_codes.OF_OUTCOME[worst]


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


def read(folder: str) -> Tuple[str, List[str], List[str], List[Tuple[str, str, str, str]], List[LeftOut], Origin]:
    """Return (title, students, exercises, [(student, exercise, attempt, handed in)], [LeftOut], Origin) of a folder.

    Raise ClassError.
    """
    path = os.path.join(folder, CLASS)
    try:
        with open(path, encoding='utf-8') as file:
            content = json.load(file)
        lists = [content[name] for name in ('students', 'exercises')]
        submissions = [(str(student), str(exercise), str(attempt), str(handed_in))
                       for student, exercise, attempt, handed_in in content['submissions']]
        left_out = [LeftOut(str(student), str(name), str(reason)) for student, name, reason in content['left_out']]
        names = [*map(str, lists[0] + lists[1]), *(name for submission in submissions for name in submission[:3])]
        if any(os.sep in name or name in ('.', '..') for name in names):
            raise ValueError('a name leads to another folder')
        return (str(content['title']), [str(name) for name in lists[0]], [str(name) for name in lists[1]], submissions,
                left_out, Origin(str(content['platform']), {str(name): str(number) for name, number in
                                                            content['ids'].items()}))
    except FileNotFoundError:
        raise ClassError(f'{path} does not exist; name folders that ./run grade --all --output has written') from None
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise ClassError(f'{path} cannot be read: {error}; name folders that ./run grade --all --output has '
                         'written') from None


def fail(error: Exception) -> int:
    text = _advice(error) if isinstance(error, OSError) else str(error)
    say(f'./run grade: {harmless.printed(text)}', sys.stderr)
    return exit_codes.USAGE


def _advice(error: OSError) -> str:
    """Return what is wrong with a file and what to do."""
    text = f'{error.filename or "the results"}: {error.strerror or error}'
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        return f'{text}. The disk is full: make room, or choose another folder with --output DIR'
    if error.errno in (errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOTDIR, errno.EEXIST, errno.ENOENT):
        return f'{text}. Choose another folder with --output DIR'
    return text
