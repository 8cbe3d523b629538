"""The table of grades that a learning platform imports, for a class that was downloaded from it. Without ROS.

Moodle: the grading worksheet of an assignment (*Upload grading worksheet*), which names a student by the participant's
number, as in the names of downloaded folders. Canvas: the gradebook (*Import*), which names one by the user's number.
Both were read in the importers' sources: importgradeslib.php of assignfeedback_offline, gradebook_importer.rb.
Gradescope imports no scores.

Moodle's worksheet also says when each student has handed in, which its ZIP does not.
"""
import csv
import datetime
from typing import Callable, Dict, List, Mapping, NamedTuple, Sequence, Tuple

MOODLE, CANVAS, GRADESCOPE = 'moodle', 'canvas', 'gradescope'
MOODLE_COLUMNS = 'Identifier', 'Full name', 'Grade', 'Last modified (grade)', 'Feedback comments'
PARTICIPANT = 'Participant '  # before the number
CANVAS_COLUMNS = 'Student', 'ID', 'SIS User ID', 'SIS Login ID', 'Section'  # of each student; then the assignments
POSSIBLE = 'Points Possible'
NUMBER, MODIFIED = 'Identifier', 'Last modified (submission)'  # columns of Moodle's worksheet
NEVER = '', '-'  # in MODIFIED of who has handed in nothing
DATES = ('%A, %d %B %Y, %I:%M %p', '%A, %d %b %Y, %I:%M %p', '%A, %d %B %Y, %H:%M', '%d %B %Y, %I:%M %p',
         '%d %B %Y, %H:%M', '%Y-%m-%d %H:%M')  # the first one is Moodle's in English
LATE = 'late'  # handed in after the deadline, nobody says when


class WorksheetError(ValueError):
    """A worksheet cannot be used; the text says why and what to do."""


class Origin(NamedTuple):
    """Where a class was downloaded: one of the platforms or '', and {student: the number that it knows them by}.

    ``times``: {path of a file, with the student: when it was handed in, in ISO 8601, or LATE}, as far as it says so.
    """

    platform: str = ''
    ids: Mapping[str, str] = {}
    times: Mapping[str, str] = {}


class Grades(NamedTuple):
    """The grades of a student: {exercise: score as text, '' without one}, their mean or '', and what to tell."""

    student: str
    scores: Mapping[str, str]
    mean: str
    comment: str


def _moodle(ids: Mapping[str, str], _exercises: Sequence[str], grades: Sequence[Grades]) -> List[Sequence[str]]:
    return [MOODLE_COLUMNS, *((f'{PARTICIPANT}{ids[one.student]}', one.student, one.mean, '', one.comment)
                              for one in grades)]


def _canvas(ids: Mapping[str, str], exercises: Sequence[str], grades: Sequence[Grades]) -> List[Sequence[str]]:
    return [(*CANVAS_COLUMNS, *exercises), (f'    {POSSIBLE}', '', '', '', '', *['100'] * len(exercises)),
            *((one.student, ids[one.student], '', '', '', *(one.scores.get(exercise, '') for exercise in exercises))
              for one in grades)]


TABLES: Dict[str, Callable[[Mapping[str, str], Sequence[str], Sequence[Grades]], List[Sequence[str]]]] = {
    MOODLE: _moodle, CANVAS: _canvas}
NAMES: Tuple[str, ...] = tuple(f'{platform}.csv' for platform in TABLES)


def table(origin: Origin, exercises: Sequence[str], grades: Sequence[Grades]) -> List[Sequence[str]]:
    """Return the rows with their headings that the platform imports; [] if it imports none."""
    known = [one for one in grades if one.student in origin.ids]
    return TABLES[origin.platform](origin.ids, exercises, known) if origin.platform in TABLES and known else []


def worksheet_times(path: str) -> Dict[str, str]:
    """Return {number of a student: when they have handed in, as in Origin} of a grading worksheet of Moodle.

    Raise WorksheetError or OSError.
    """
    found: Dict[str, str] = {}
    try:
        with open(path, encoding='utf-8-sig', newline='') as file:
            reader = csv.DictReader(file)
            if not {NUMBER, MODIFIED} <= set(reader.fieldnames or ()):
                raise WorksheetError(f'{path} has no columns {NUMBER!r} and {MODIFIED!r}: set the language of Moodle '
                                     'to English, and choose Download grading worksheet in the assignment')
            for row in reader:
                if (row[MODIFIED] or '').strip() not in NEVER:
                    found[(row[NUMBER] or '').rpartition(' ')[2]] = _time(row[MODIFIED], f'{path}, line '
                                                                          f'{reader.line_num}')
    except (csv.Error, UnicodeDecodeError) as error:
        raise WorksheetError(f'{path} is not CSV in UTF-8: {error}; choose Download grading worksheet in the '
                             'assignment') from None
    return found


def _time(text: str, where: str) -> str:
    for layout in DATES:
        try:
            return datetime.datetime.strptime(text.strip(), layout).isoformat(' ', 'minutes')
        except ValueError:
            continue
    raise WorksheetError(f'{where}: {MODIFIED} is {text!r}; it must be a date such as Friday, 20 November 2026, '
                         '6:05 PM, as Moodle writes it in English')
