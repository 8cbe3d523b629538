"""The table of grades that a learning platform imports, for a class that was downloaded from it. Without ROS.

Moodle: the grading worksheet of an assignment (*Upload grading worksheet*), which names a student by the participant's
number, as in the names of downloaded folders. Canvas: the gradebook (*Import*), which names one by the user's number.
Both were read in the importers' sources: importgradeslib.php of assignfeedback_offline, gradebook_importer.rb.
Gradescope imports no scores.
"""
from typing import Callable, Dict, List, Mapping, NamedTuple, Sequence, Tuple

MOODLE, CANVAS, GRADESCOPE = 'moodle', 'canvas', 'gradescope'
MOODLE_COLUMNS = 'Identifier', 'Full name', 'Grade', 'Last modified (grade)', 'Feedback comments'
PARTICIPANT = 'Participant '  # before the number
CANVAS_COLUMNS = 'Student', 'ID', 'SIS User ID', 'SIS Login ID', 'Section'  # of each student; then the assignments
POSSIBLE = 'Points Possible'
LATE = 'late'  # handed in after the deadline, nobody says when


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
