"""The output of one grading for the systems of teachers: ``./run grade --format NAME``.

Each format defines standard output, the files to write (None: to remove), and the exit code. If a system reads a score,
the exit code is 0 for any score; an undecided grading then has no result and the exit code 3, which the system shows as
a failure of its own.
"""
import base64
import contextlib
import datetime
import html
import json
import os
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Optional, Sequence, Union

from course_grader.formats import csv_table, exit_codes, harmless, junit, report
from course_grader.rules import judging, scoring
from course_grader.rules.exercise import Exercise
from course_grader.rules.scoring import Verdict
from plain_support import write_whole

TEXT = 'text'  # the format for people
HIGHEST = 100  # score
PICTURE = 'path.png'  # in the folder of a grading
CLASSROOM50_SCHEMA = 'classroom50/result/v1'
CLASSROOM50_NAMES = ('CLASSROOM', 'ASSIGNMENT', 'SUBMISSION_TAG', 'COMMIT_URL', 'RELEASE_URL')  # set by its runner
VISIBILITY = {judging.ALWAYS: 'visible', judging.LATER: 'after_due_date', judging.NEVER: 'hidden'}  # of Gradescope
VPL_NAMES = ('VPL_GRADEMIN', 'VPL_GRADEMAX')


class Grading(NamedTuple):
    """One grading: the exercise, the command, the verdict, and the folder with its files.

    ``notes`` are lines for the end of the text; ``isolation`` is the level at which the program ran.
    """

    exercise: Exercise
    command: Sequence[str]
    decided: Verdict
    seconds: float
    folder: str
    notes: Sequence[str] = ()
    isolation: str = ''


METADATA = 'submission_metadata.json'  # of Gradescope
NAMES_OF_STUDENTS = {'classroom50': ('OWNER', 'USERNAME'),
                     'vpl': ('MOODLE_GROUP_NAME', 'MOODLE_USER_NAME')}  # variables, the first that is set


class Runner(NamedTuple):
    """The machine that runs the grader: its environment, current folder, and where Gradescope has its files."""

    environment: Mapping[str, str]
    folder: str = '.'
    autograder: str = '/autograder'


class Written(NamedTuple):
    """A grading in a format: standard output, {path: content or None}, exit code."""

    stdout: str
    files: Mapping[str, Union[bytes, str, None]]
    code: int


class FormatError(ValueError):
    """A format cannot be used here; the text says why and what to do."""


def detect(runner: Runner) -> str:
    """Return the format of the system that runs the grader, or TEXT."""
    if all(runner.environment.get(name) for name in CLASSROOM50_NAMES):
        return 'classroom50'
    if all(os.path.isdir(os.path.join(runner.autograder, name)) for name in ('submission', 'results')):
        return 'gradescope'
    if all(runner.environment.get(name) for name in VPL_NAMES):
        return 'vpl'
    return TEXT


def student(name: str, runner: Runner) -> str:
    """Return the name that a system has for the student, or for all of a group, or ''.

    Classroom 50: of the account; Gradescope: as in the roster; VPL: as in Moodle, of a group its name.
    """
    if name == 'gradescope':
        try:
            with open(os.path.join(runner.autograder, METADATA), encoding='utf-8') as file:
                return ' and '.join(sorted(str(user['name']).strip() for user in json.load(file)['users']))
        except (OSError, ValueError, KeyError, TypeError):
            return ''
    return next((runner.environment[key].strip() for key in NAMES_OF_STUDENTS.get(name, ())
                 if runner.environment.get(key, '').strip()), '')


def check(name: str, runner: Runner) -> None:
    """Raise FormatError if the runner lacks something that a format needs; call it before the grading."""
    missing = [name for name in CLASSROOM50_NAMES if not runner.environment.get(name)]
    if name == 'classroom50' and missing:
        raise FormatError(f'--format classroom50 needs {", ".join(missing)} in the environment, which the runner of '
                          'Classroom 50 sets; choose another format elsewhere')
    if name == 'gradescope' and not os.path.isdir(runner.autograder):
        raise FormatError(f'--format gradescope writes to {runner.autograder}/results, but there is no folder '
                          f'{runner.autograder}; choose another format outside of Gradescope')


def rendered(name: str, grading: Grading, runner: Runner) -> Written:
    return FORMATS[name](grading, runner)


def write(written: Written) -> None:
    """Write and remove the files of a format, replacing links of a student; raise OSError."""
    for path, content in written.files.items():
        if content is None or os.path.islink(path):
            with contextlib.suppress(FileNotFoundError):
                os.remove(path)
        if content is not None:
            os.makedirs(os.path.dirname(path) or '.', exist_ok=True)
            write_whole(path, content)


def text(grading: Grading, runner: Runner) -> Written:
    """For people."""
    return Written(_text(grading), {}, exit_codes.OF_OUTCOME[grading.decided.outcome])


def classroom50(grading: Grading, runner: Runner) -> Written:
    """result.json, release-body.md and path.png in the current folder, which is the student's repository."""
    result, body, picture = (os.path.join(runner.folder, *parts) for parts in
                             (('result.json',), ('release-body.md',), (PICTURE,)))
    if _undecided(grading):
        return Written(_text(grading), {result: None, body: None}, _code(grading))
    decided = grading.decided
    environment = runner.environment
    tests = [{'test-name': row.name, 'passed': row.passed, 'score': int(row.points), 'max-score': int(row.of)}
             for row in _rows(grading) if row.visibility == VISIBILITY[judging.ALWAYS]]
    content = {
        'schema': CLASSROOM50_SCHEMA, 'classroom': environment['CLASSROOM'], 'assignment': environment['ASSIGNMENT'],
        'assignment_type': environment.get('ASSIGNMENT_TYPE') or 'individual',
        'owner': environment.get('OWNER') or environment.get('USERNAME') or environment.get('GITHUB_ACTOR', ''),
        'submission': environment['SUBMISSION_TAG'], 'commit': environment['COMMIT_URL'],
        'release': environment['RELEASE_URL'],
        'review': environment.get('REVIEW_URL') or environment['COMMIT_URL'],
        'datetime': datetime.datetime.now(datetime.timezone.utc).strftime('%Y-%m-%dT%H:%M:%SZ'),
        'score': int(decided.score), 'max-score': HIGHEST, 'tests': tests}
    heading = f'### {harmless.plain(grading.exercise.title)}: {decided.outcome}, {int(decided.score)} of {HIGHEST}\n\n'
    image = _picture(grading)
    block = harmless.fenced(report.text(grading.exercise, decided))
    files: Dict[str, Union[bytes, str, None]] = {result: _json(content), body: heading + block}
    if image:
        files[picture] = image
    return Written(_text(grading), files, _code(grading))


def gradescope(grading: Grading, runner: Runner) -> Written:
    """results/results.json of Gradescope; an undecided grading keeps the score of the student's last submission."""
    path = os.path.join(runner.autograder, 'results', 'results.json')
    score: Optional[float] = grading.decided.score
    if _undecided(grading):
        score = _last_score(os.path.join(runner.autograder, 'submission_metadata.json'))
    if score is None:
        return Written(_text(grading), {path: None}, _code(grading))
    shown = html.escape(harmless.plain(report.text(grading.exercise, grading.decided)))
    content: Dict[str, Any] = {'score': score, 'execution_time': round(grading.seconds), 'output_format': 'html',
                               'output': f'<pre>{shown}</pre>', 'visibility': 'visible', 'stdout_visibility': 'hidden'}
    if _undecided(grading):
        content['output'] += '<p>There is no verdict. The score of your last submission stays: submit again.</p>'
        return Written(_text(grading), {path: _json(content)}, _code(grading))
    image = _picture(grading)
    if image:
        content['output'] += f'<img alt="the path" src="data:image/png;base64,{base64.b64encode(image).decode()}">'
    content['tests'] = [
        {'name': row.name, 'number': str(number), 'score': row.points, 'max_score': row.of,
         'status': 'passed' if row.passed else 'failed', 'output': row.seen, 'output_format': 'text',
         'visibility': row.visibility} for number, row in enumerate(_rows(grading), 1)]
    return Written(_text(grading), {path: _json(content)}, _code(grading))


def vpl(grading: Grading, runner: Runner) -> Written:
    """A block of comments and a grade between VPL_GRADEMIN and VPL_GRADEMAX, for VPL of Moodle."""
    lowest, highest = _vpl_grades(runner.environment)
    first, *others = _text(grading).split('\n')
    lines = ['<|--', f'-{first}', *(f'>{line}' for line in others), '--|>']
    if not _undecided(grading):
        grade = lowest + (highest - lowest) * grading.decided.score / HIGHEST
        lines.append(f'Grade :=>> {round(grade, 2):g}')
    return Written('\n'.join(lines), {}, _code(grading))


def autolab(grading: Grading, runner: Runner) -> Written:
    """The text, and in the last line the score of the problem that has the name of the exercise."""
    if _undecided(grading):
        return Written(f'{_text(grading)}\nNo score: there is no verdict.', {}, _code(grading))
    score = json.dumps({'scores': {grading.exercise.name: grading.decided.score}})
    return Written(f'{_text(grading)}\n{score}', {}, _code(grading))


def as_junit(grading: Grading, runner: Runner) -> Written:
    """JUnit XML, and nothing else, on standard output."""
    name = ' '.join(grading.command) or grading.exercise.name
    suite = junit.Suite(name, grading.exercise.name, grading.decided.public(), grading.seconds,
                        grading.isolation)
    return Written(junit.document([suite]).rstrip('\n'), {}, exit_codes.OF_OUTCOME[grading.decided.outcome])


def as_csv(grading: Grading, runner: Runner) -> Written:
    """A heading and a row, and nothing else, on standard output."""
    row = csv_table.Row(' '.join(grading.command), grading.exercise.name, grading.decided.public(), grading.isolation)
    table = csv_table.gradings('program', [row])
    return Written(table.rstrip('\n'), {}, exit_codes.OF_OUTCOME[grading.decided.outcome])


FORMATS: Dict[str, Callable[[Grading, Runner], Written]] = {
    TEXT: text, 'classroom50': classroom50, 'gradescope': gradescope, 'vpl': vpl, 'autolab': autolab,
    'junit': as_junit, 'csv': as_csv}
READ_SCORES = frozenset(FORMATS) - {TEXT, 'junit', 'csv'}  # the exit code is 0 for any score


class _Row(NamedTuple):
    """A check as shown by the systems: its points, and whether they are enough."""

    name: str
    seen: str
    passed: bool
    points: float
    of: float
    visibility: str = 'visible'  # in Gradescope


def _rows(grading: Grading) -> List[_Row]:
    """Return a row for each check, or one for the exercise if the program could not be judged."""
    decided = grading.decided
    counted = decided.score > 0.0  # a shortcut costs the points of all checks
    rows = [_Row(harmless.plain(f'{reason.check}: {reason.asked}'), harmless.plain(f'seen: {reason.seen}'),
                 decided.outcome == scoring.PASSED or (counted and reason.points >= reason.of),
                 reason.points if counted else 0.0, reason.of, VISIBILITY[reason.visible])
            for reason in decided.reasons]
    return rows or [_Row(harmless.plain(grading.exercise.title), harmless.plain('\n'.join(decided.objections)), False,
                         0.0, float(HIGHEST))]


def _text(grading: Grading) -> str:
    return harmless.printed('\n'.join((report.text(grading.exercise, grading.decided), *grading.notes)))


def _undecided(grading: Grading) -> bool:
    return grading.decided.outcome == scoring.UNDECIDED


def _code(grading: Grading) -> int:
    """Return the exit code for a system that reads a score: 0 if there is one."""
    return exit_codes.OF_OUTCOME[scoring.UNDECIDED if _undecided(grading) else scoring.PASSED]


def _json(content: object) -> str:
    return json.dumps(content, indent=2) + '\n'


def _picture(grading: Grading) -> bytes:
    """Return the picture of the path, b'' if there is none."""
    with contextlib.suppress(OSError), open(os.path.join(grading.folder, PICTURE), 'rb') as file:
        return file.read()
    return b''


def _last_score(path: str) -> Optional[float]:
    """Return the score of the student's last submission in Gradescope's metadata, or None."""
    try:
        with open(path, encoding='utf-8') as file:
            return float(json.load(file)['previous_submissions'][-1]['score'])
    except (OSError, ValueError, TypeError, KeyError, IndexError):
        return None


def _vpl_grades(environment: Mapping[str, str]) -> Sequence[float]:
    """Return the lowest and the highest grade."""
    try:
        return [float(environment[name]) for name in VPL_NAMES]
    except (KeyError, ValueError):
        return [0.0, float(HIGHEST)]
