"""The bench of the grader: what grading takes on the wall clock, and whether the same program gets the same verdict.

The programs are the right ones of test/data/submissions that follow simulated time; the others take their exercise's
time. No node is needed: a grading brings its own. See suite_turtlesim for what a suite is.
"""

import collections
import json
import os
import shutil
import tempfile
import time
from pathlib import Path

from figures import Figure, Target, median
from processes import BenchError, Child
from suite_turtlesim import Measurement

NEEDS_NODE = False
REPOSITORY = Path(__file__).resolve().parents[1]
SAMPLES = REPOSITORY / 'test' / 'data' / 'submissions'
GRADER = 'python3', str(REPOSITORY / 'scripts' / 'grade.py')
EXERCISES = sorted(path.name for path in SAMPLES.iterdir() if path.is_dir())
REPEATED = 'square_by_topics', 'right_four_positions.py'
REAL_TIME = 'right_busy_loop', 'right_wall_clock'
SEED = 7
LIMIT = 120.0  # [s] of one grading
FULL, QUICK = 100, 8  # repeats of one grading
AT_ONCE = 4
CLASS_JOBS = 2  # as many as a grading on 2 cores gets by default


def right_program(exercise):
    """Return the first right Python program of an exercise that need not be graded in real time."""
    return min(path for path in (SAMPLES / exercise).glob('right_*.py') if path.stem not in REAL_TIME)


def grade(arguments, limit):
    """Return the grader's wall time [s]; raise BenchError when the result is undecided or it does not end."""
    folder = tempfile.mkdtemp(prefix='turtle_robotont_bench_')
    try:
        begun = time.perf_counter()
        with Child('grader', [*GRADER, *arguments], dict(os.environ), folder) as child:
            while child.process.poll() is None:
                if time.perf_counter() - begun > limit:
                    raise BenchError(f'{" ".join(arguments)} took more than {limit:.0f} s:\n{child.tail()}')
                time.sleep(0.01)
            if child.process.returncode:
                raise BenchError(f'{" ".join(arguments)}: exit code {child.process.returncode}:\n{child.tail()}')
        return time.perf_counter() - begun
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def one(exercise):
    """Return the measurement of one exercise while nothing else is graded."""
    def run(_subject, _scale):
        with tempfile.TemporaryDirectory(prefix='turtle_robotont_bench_') as output:
            seconds = grade([exercise, '--seed', str(SEED), '--output', output, '--', str(right_program(exercise))],
                            LIMIT)
        return {exercise: [seconds], 'alone': [seconds]}
    return run


def whole_class(_subject, _scale):
    """A student who hands in every exercise: the time of each grading."""
    with tempfile.TemporaryDirectory(prefix='turtle_robotont_bench_') as folder:
        student = Path(folder, 'class', 'student')
        student.mkdir(parents=True)
        for exercise in EXERCISES:
            shutil.copy(right_program(exercise), student / f'{exercise}.py')
        seconds = grade(['--all', str(student.parent), '--seed', str(SEED), '--jobs', str(CLASS_JOBS), '--output',
                         str(Path(folder, 'out'))], LIMIT * len(EXERCISES))
    return {'class': [seconds / len(EXERCISES)]}


def repeats(_subject, times):
    """Grade one program many times, four at once: the share of the most frequent verdict, and the time of each."""
    exercise, program = REPEATED
    with tempfile.TemporaryDirectory(prefix='turtle_robotont_bench_') as folder:
        for number in range(times):
            student = Path(folder, 'class', f'student{number:03}')
            student.mkdir(parents=True)
            shutil.copy(SAMPLES / exercise / program, student / f'{exercise}.py')
        output = Path(folder, 'out')
        seconds = grade(['--all', str(Path(folder, 'class')), '--seed', str(SEED), '--jobs', str(AT_ONCE),
                         '--output', str(output)], LIMIT * times / AT_ONCE)
        verdicts = collections.Counter(_verdict(path) for path in output.glob('*/*/result.json'))
    return {'equal': [100.0 * verdicts.most_common(1)[0][1] / times], 'equal ones': [seconds / times]}


def _verdict(path):
    result = json.loads(path.read_text(encoding='utf-8'))
    points = tuple(reason['points'] for reason in result['reasons'])
    return result['outcome'], result['score'], tuple(result['objections']), points


MEASUREMENTS = {
    **{exercise: Measurement(one(exercise), f'{exercise}, {right_program(exercise).name}') for exercise in EXERCISES},
    'class': Measurement(whole_class, f'a class with all {len(EXERCISES)} exercises, {CLASS_JOBS} at once'),
    'repeats': Measurement(repeats, f'{REPEATED[1]} {FULL} times, {AT_ONCE} at once'),
}
FIGURES = (
    *(Figure(f'grading {exercise}', exercise, 's', median, Target('at_most', 6.0)) for exercise in EXERCISES),
    Figure('grading, median of the exercises', 'alone', 's', median, Target('at_most', 3.0)),
    Figure('grading, longest', 'alone', 's', max, Target('at_most', 6.0)),
    Figure(f'class of all exercises, {CLASS_JOBS} at once, per grading', 'class', 's', median, Target('at_most', 2.5)),
    Figure(f'{REPEATED[0]} again and again, {AT_ONCE} at once, per grading', 'equal ones', 's', median,
           Target('at_most', 2.5)),
    Figure('equal verdicts', 'equal', '%', min, Target('at_least', 100.0)),
)
