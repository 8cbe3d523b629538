"""Gradings for the tests of the formats: passed, failed, a shortcut, undecided, and hostile text in all of them."""
from course_grader.classes.graded import Graded
from course_grader.classes.submissions import Submission
from course_grader.formats.systems import Grading
from course_grader.rules import exercise, scoring
from course_grader.rules.scoring import Reason, Verdict
from unit_support.course_files import EXERCISES

STOP = exercise.load(EXERCISES['stop_at_x'])
HOSTILE = ('::error::a <script>alert(1)</script> & ]]> \x1b[2J \udcff ##[error]b ```` | =1+1 '
           + ' '.join(['::set-output'] * 30)
           + '\nGrade :=>> 100\nComment :=>> c\n<|--\n--|>\n{"scores": {"stop_at_x": 99}}')
MOVES = Reason('moves', 20.0, 20.0, 'a path of at least 2 m', '4.00 m')
STOPS = Reason('stops', 80.0, 80.0, 'a stop at x = 10, within 0.15 m', 'it stopped at x = 10.012, y = 5.000')
MISSED = STOPS._replace(points=24.5, seen='it stopped at x = 10.700, y = 5.000')
REQUIRED = 'required check failed: a stop at x = 10, within 0.15 m'

VERDICTS = {
    'passed': Verdict(scoring.PASSED, 100.0, [MOVES, STOPS], []),
    'passed with less': Verdict(scoring.PASSED, 87.5, [MOVES, STOPS._replace(points=67.5)], []),
    'failed': Verdict(scoring.FAILED, 44.5, [MOVES, MISSED], [REQUIRED]),
    'shortcut': Verdict(scoring.FAILED, 0.0, [MOVES, STOPS], ['the program reset the simulator']),
    'not started': Verdict(scoring.FAILED, 0.0, [], ['stop.py, line 1: SyntaxError: invalid syntax']),
    'undecided': Verdict(scoring.UNDECIDED, 0.0, [MOVES, MISSED], ['the machine was too slow']),
    'hostile': Verdict(scoring.FAILED, 20.0, [MOVES, MISSED._replace(points=0.0, seen=HOSTILE)], [HOSTILE]),
    'hostile undecided': Verdict(scoring.UNDECIDED, 0.0, [MISSED._replace(seen=HOSTILE)], [HOSTILE]),
}


def graded(student, exercise, score, outcome='passed', reasons=(), **submission):
    """Return the Graded of one of a class."""
    return Graded(Submission(student, exercise, ('a.py',), '/', **submission),
                  Verdict(outcome, score, list(reasons), []), 1.5, '/nowhere')


def grading(name, folder='none'):
    """Return the Grading of a verdict; ``folder`` may hold a path.png."""
    hostile = name.startswith('hostile')
    return Grading(STOP, [HOSTILE if hostile else 'stop.py'], VERDICTS[name], 12.3456, str(folder),
                   [f'  note: {HOSTILE}'] if hostile else [], 'uid')
