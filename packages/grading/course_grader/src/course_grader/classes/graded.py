"""A grading of a class as stored in its folder, so that the next run skips unchanged submissions. Without ROS.

The folder has the files of every grading (result.json has the verdict), and RECORD with what the class needs, too.
"""
import hashlib
import json
import os
import time
from pathlib import Path
from typing import Any, Container, Dict, Iterable, List, Mapping, NamedTuple, Tuple

from course_grader.classes.submissions import Submission
from course_grader.formats import harmless, platforms
from course_grader.isolation import student_files
from course_grader.isolation.limits import MEGABYTE
from course_grader.rules import judging, scoring
from course_grader.rules.scoring import Reason, Verdict
from kinematic_core.worlds import turtle_world
from plain_support import files, write_whole

RECORD, RESULT = 'submission.json', 'result.json'
TABLES = 'scores.csv', 'grades.csv', 'index.html', 'junit.xml'  # in the folder of a class, beside those of the students
CODES, ANONYMOUS = 'codes.csv', 'anonymous.csv'  # for the teacher only; the table without names
PAGES, CLASS = 'pages', 'class.json'  # folder of the students' pages; see class_results.py
HANDED_IN = 'handed_in'  # folder of what downloads.py has unpacked
SIMILAR, PAIRS = 'similar', 'similar.csv'  # folder of pages with two similar programs each, and their table
MARKS = 'marks.csv'  # what a teacher gives by hand; see marks.py
DEADLINES = 'deadlines.csv'  # see deadlines.py
RESERVED = (*TABLES, *platforms.NAMES, CODES, ANONYMOUS, PAGES, CLASS, HANDED_IN, SIMILAR, PAIRS, MARKS, DEADLINES)
LONGEST_NAME = 200  # [bytes] of a folder; Linux allows 255, with an ending
NOT_GRADED = 'it is not graded yet'
MAX_HASHED = 64 * MEGABYTE  # [bytes] of a file that are compared
SOURCES = [Path(__file__).parents[1], Path(turtle_world.__file__).parents[1],  # of the grader, its worlds,
           Path(files.__file__).parent]  # and what they stand on


class Graded(NamedTuple):
    """A submission and its verdict: the wall time [s], the folder with the files, the seed, and when it was graded [s].

    ``repeat``: the arguments that grade it again; ``isolation``: the level of isolation, '' if unknown; ``notes``:
    remarks that change no score; ``over``: whether its deadline is over; ``asks``: the task, ``title``: its heading.
    """

    submission: Submission
    verdict: Verdict
    seconds: float
    folder: str
    seed: int = 0
    repeat: Tuple[str, ...] = ()
    isolation: str = ''
    at: float = 0.0
    notes: Tuple[str, ...] = ()
    over: bool = False
    title: str = ''
    asks: str = ''

    @property
    def outcome(self) -> str:
        return self.verdict.outcome

    @property
    def score(self) -> float:
        """Return the score, 0 to 100."""
        return self.verdict.score


class Unreadable(ValueError):
    """A folder contains no grading."""


def undecided(submission: Submission, folder: str, reason: str, seconds: float = 0.0) -> Graded:
    """Return a Graded without a verdict."""
    return Graded(submission, Verdict(scoring.UNDECIDED, 0.0, [], [reason]), seconds, folder)


def folder_of(submission: Submission, output: str) -> str:
    return os.path.join(output, *map(name_of_folder, filter(None, (submission.student, submission.exercise,
                                                                   submission.attempt))))


def name_of_folder(name: str) -> str:
    """Return a name as that of a folder or page: not too long, without control characters, and not a file of a class.
    """
    plain = harmless.plain(name)
    if plain == name and len(os.fsencode(name)) <= LONGEST_NAME and name not in RESERVED:
        return name
    short = os.fsencode(plain)[:LONGEST_NAME].decode('utf-8', 'ignore')
    return f'{short}~{hashlib.sha256(name.encode("utf-8", "surrogateescape")).hexdigest()[:8]}'


def save(folder: str, fingerprint: str, seconds: float, repeat: Iterable[str]) -> None:
    """Write the RECORD of a grading whose other files are there; raise OSError."""
    content = {'fingerprint': fingerprint, 'seconds': round(seconds, 2), 'repeat': list(repeat), 'at': time.time()}
    write_whole(os.path.join(folder, RECORD), json.dumps(content, indent=2) + '\n')


def load(submission: Submission, folder: str, fingerprint: str = '') -> Graded:
    """Return the grading in a folder; raise Unreadable if there is none.

    It must have the ``fingerprint``, if that is given.
    """
    try:
        record, result = _read(os.path.join(folder, RECORD)), _read(os.path.join(folder, RESULT))
        if fingerprint and record['fingerprint'] != fingerprint:
            raise Unreadable(f'{folder}: the submission has changed')
        if result['outcome'] not in (scoring.PASSED, scoring.FAILED, scoring.UNDECIDED):
            raise ValueError(f'outcome {result["outcome"]!r}')
        reasons = [Reason(str(entry['check']), float(entry['points']), float(entry['of']), str(entry['asked']),
                          str(entry['seen']), str(entry.get('visible', judging.ALWAYS))) for entry in result['reasons']]
        verdict = Verdict(result['outcome'], float(result['score']), reasons, _texts(result['objections']),
                          tuple(_texts(result['hints'])), bool(result.get('certain')))
        return Graded(submission, verdict, float(record['seconds']), folder, int(result['seed']),
                      tuple(_texts(record['repeat'])), str(result.get('isolation') or ''), float(record['at']),
                      tuple(_texts(result.get('notes', []))), title=str(result.get('title', '')),
                      asks=str(result.get('asks', '')))
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise Unreadable(f'{folder} holds no grading: {error}') from None


def _read(path: str) -> Any:
    with open(path, encoding='utf-8') as file:
        return json.load(file)


def _texts(value: object) -> List[str]:
    if not isinstance(value, list):
        raise ValueError(f'{value!r} is not a list')
    return [str(entry) for entry in value]


def version() -> str:
    """Return a digest of the grader's source; with another one, submissions are graded again."""
    return _digest(path for folder in SOURCES for path in sorted(folder.rglob('*.py')))


def files_of(submission: Submission, programs: Container[str]) -> Dict[str, str]:
    """Return {name below its folder: path} of all files that a submission may need.

    ``programs``: those of all submissions of the class, of which others are left out unless this program names them.
    Links that lead out of the folder are left out, too: see root_of().
    """
    root = root_of(submission)
    text = student_files.read(submission.program)
    files = {}
    for parent, folders, names in student_files.walk(root):
        folders[:] = [name for name in folders if not name.startswith(('.', '__pycache__'))]
        if not submission.packages:
            del folders[:]  # the folders are other students'
        for name in names:
            path = os.path.join(parent, name)
            own = path == submission.program or path not in programs or os.fsencode(
                os.path.splitext(name)[0]) in text
            inside = os.path.realpath(path).startswith(os.path.realpath(root) + os.sep)
            if own and inside and os.path.isfile(path):
                files[os.path.relpath(path, root)] = path
    return files


def root_of(submission: Submission) -> str:
    """Return the folder of a student, or that of the class if it contains the programs themselves."""
    return submission.packages or submission.folder


def fingerprint_of(submission: Submission, files: Mapping[str, str], exercise: str, *others: object) -> str:
    """Return a digest of everything that a verdict may depend on.

    ``files``: see files_of(); ``exercise``: the path of its file; ``others``: further values, such as version().
    """
    command = [part.replace(root_of(submission) + os.sep, '') for part in submission.command]
    executable = [os.access(path, os.X_OK) for path in files.values()]
    parts = repr([command, submission.trouble, bool(submission.packages), list(files), executable, others])
    return hashlib.sha256((_digest([exercise, *files.values()]) + parts).encode()).hexdigest()


def _digest(paths: Iterable[object]) -> str:
    digest = hashlib.sha256()
    for path in paths:
        digest.update(hashlib.sha256(student_files.read(str(path), MAX_HASHED)).digest())
    return digest.hexdigest()
