"""The bench of the grader: what grading takes on the wall clock, and whether the same program gets the same verdict.

The programs are the samples of the course, among them the patterns of the official tutorials. What is timed
follows simulated time; the others take as long as their exercise. No node is needed: a grading brings its own.
"""

import collections
import json
import os
import sys
import tempfile
import time
import uuid
from functools import partial
from pathlib import Path

import psutil

from check_grading import hand_in
from figures import Figure, Target, median
from plain_support import course, processes
from processes import BenchError, Child, tree_memory
from session import Measurement

NEEDS_NODE = False
REPOSITORY = Path(__file__).resolve().parents[2]
FILES = course.exercises(REPOSITORY / 'course')
GRADER = 'python3', str(REPOSITORY / 'packages' / 'grading' / 'course_grader' / 'scripts' / 'grade')
EXERCISES = sorted(name for name, path in FILES.items() if course.samples(path))
BORDERLINE = 'right_borderline'  # passes with the SEED, and fails with some others
REAL_TIME = 'right_busy_loop', 'right_wait_for_message', 'right_wall_clock'  # their scores may differ
SEED = 7
LIMIT = 120.0  # [s] of one grading
FULL, QUICK = 100, 4  # repeats of one grading
MANY = 'print_marker_ids'  # a short one
MEMORY_PERIOD = 0.5  # [s]
MARK = 'TURTLE_ROBOTONT_BENCH'  # environment variable of all processes of a run
CLASS_JOBS = 2  # as many as a grading on 2 cores gets by default
_folder = partial(tempfile.TemporaryDirectory, prefix='turtle_robotont_bench_')


def right_program(exercise):
    """Return the first right program of an exercise that need not be graded in real time, with any seed."""
    printed = course.printed_answer(FILES[exercise])
    return printed or min(path for path in _programs(exercise, 'right_*')
                          if path.stem not in (*REAL_TIME, BORDERLINE))


def _programs(exercise, name, both=False):
    """Return the samples of this name in Python, or, of an exercise without these, other ones; or both."""
    python, launch, commands, maps = (list((FILES[exercise].parent / 'samples' / exercise).glob(f'{name}.{ending}'))
                                      for ending in ('py', 'launch', 'cmd', 'yaml'))
    others = launch + commands + maps
    return python + others if both else python or others


def grade(arguments, limit, accepted=(0,), environment=os.environ, watch=lambda pid: None):
    """Return the grader's wall time [s]; raise BenchError when its exit code is none of ``accepted``, or it hangs.

    ``watch`` is called again and again with its process id.
    """
    with _folder() as folder, Child('grader', [*GRADER, *arguments], dict(environment), folder) as child:
        begun = time.perf_counter()
        while child.runs():
            watch(child.pid)
            if time.perf_counter() - begun > limit:
                raise BenchError(f'{" ".join(arguments)} took more than {limit:.0f} s:\n{child.tail()}')
            time.sleep(0.01)
        seconds, code = time.perf_counter() - begun, child.process.returncode
        if code not in accepted:
            raise BenchError(f'{" ".join(arguments)}: exit code {code}:\n{child.tail()}')
        return seconds


def one(exercise):
    """Return the measurement of one exercise while nothing else is graded."""
    def run(_subject, _scale):
        with _folder() as output:
            seconds = grade([exercise, '--seed', str(SEED), '--output', output, '--', str(right_program(exercise))],
                            LIMIT)
        return {exercise: [seconds], 'alone': [seconds]}
    return run


def whole_class(_subject, _scale):
    """Grade a class in which every exercise is handed in once: the time of each grading."""
    with _folder() as folder:
        for exercise in EXERCISES:  # a folder for each, because that of the launch file is a package
            hand_in(exercise, right_program(exercise), Path(folder, 'class', exercise))
        seconds = grade(['--all', str(Path(folder, 'class')), '--seed', str(SEED), '--jobs', str(CLASS_JOBS),
                         '--output', str(Path(folder, 'out'))], LIMIT * len(EXERCISES))
    return {'class': [seconds / len(EXERCISES)]}


def repeats(exercise):
    """Return the measurement of all right programs of an exercise, each graded again and again with one seed.

    For each: the share of passed gradings, and of those with its most frequent score and points.
    """
    def run(_subject, times):
        programs = sorted(_programs(exercise, 'right_*', both=True))
        with _folder() as folder:
            for program in programs:
                for number in range(times):
                    hand_in(exercise, program, Path(folder, 'class', f'{program.stem}{number:03}'))
            output, count = Path(folder, 'out'), times * len(programs)
            grade(['--all', str(Path(folder, 'class')), '--seed', str(SEED), '--jobs', str(CLASS_JOBS), '--output',
                   str(output)], LIMIT * count, accepted=(0, 1, 3))
            verdicts = {program.stem: collections.Counter(map(_verdict, output.glob(
                f'{program.stem}[0-9]*/{exercise}/result.json'))) for program in programs}
        passed, equal = [], []
        for name, counted in verdicts.items():
            right = sum(number for verdict, number in counted.items() if verdict[0] == 'passed')
            passed.append(100.0 * right / times)
            if name not in REAL_TIME:
                equal.append(100.0 * counted.most_common(1)[0][1] / times)
            if right < times or name not in REAL_TIME and len(counted) > 1:
                for verdict, number in counted.most_common():
                    print(f'    {name}, {number} of {times}: {verdict}', file=sys.stderr)
        return {'passed': passed, **({'equal': equal} if equal else {})}
    return run


def many(_subject, times):
    """Grade ten times as many in one run: its memory at the end, compared with the beginning, and its leftovers."""
    mark, samples = uuid.uuid4().hex, []

    def watch(pid):
        if not samples or time.monotonic() >= samples[-1][0] + MEMORY_PERIOD:
            samples.append((time.monotonic(), tree_memory(pid)[0]))
    with _folder() as folder:
        for number in range(10 * times):
            hand_in(MANY, right_program(MANY), Path(folder, 'class', f'student{number:04}'))
        temporary = Path(folder, 'tmp')
        temporary.mkdir()
        seconds = grade(['--all', str(Path(folder, 'class')), '--jobs', str(CLASS_JOBS), '--output',
                         str(Path(folder, 'out'))], LIMIT * times,
                        environment={**os.environ, 'TMPDIR': str(temporary), MARK: mark}, watch=watch)
        left = [*temporary.rglob('*'), *processes.related(f'{MARK}={mark}', psutil.Process())]
    for one in left:
        print(f'    left behind: {one}', file=sys.stderr)
    tenth = max(1, len(samples) // 10)
    first, last = (median([memory for _, memory in part]) for part in (samples[tenth:2 * tenth], samples[-tenth:]))
    return {'many': [seconds / (10 * times)], 'memory': [last - first], 'left': [len(left)]}


def _verdict(path):
    result = json.loads(path.read_text(encoding='utf-8'))
    points = tuple(reason['points'] for reason in result['reasons'])
    return result['outcome'], result['score'], tuple(result['objections']), points


MEASUREMENTS = {
    **{exercise: Measurement(one(exercise), f'{exercise}, {right_program(exercise).name}') for exercise in EXERCISES},
    'class': Measurement(whole_class, f'a class with all {len(EXERCISES)} exercises, {CLASS_JOBS} at once'),
    **{f'repeats {exercise}': Measurement(repeats(exercise), f'all right programs of {exercise}, --times ({FULL}) each')
       for exercise in EXERCISES},
    'many': Measurement(many, f'{10 * FULL} gradings of {MANY} in one run'),
}
FIGURES = (
    *(Figure(f'grading {exercise}', exercise, 's', median, Target('at_most', 6.0)) for exercise in EXERCISES),
    Figure('grading, median of the exercises', 'alone', 's', median, Target('at_most', 3.0)),
    Figure('grading, longest', 'alone', 's', max, Target('at_most', 6.0)),
    Figure(f'class of all exercises, {CLASS_JOBS} at once, per grading', 'class', 's', median, Target('at_most', 1.5)),
    Figure('one run with many, per grading', 'many', 's', median, Target('at_most', 2.5)),
    Figure('memory of a run, at its end more than at its beginning', 'memory', 'MB', max, Target('at_most', 5.0)),
    Figure('files and processes that a run leaves', 'left', '', max, Target('at_most', 0.0)),
    Figure('passed gradings of right programs, the least of a program', 'passed', '%', min, Target('at_least', 100.0)),
    Figure('equal scores of a right program, the least', 'equal', '%', min, Target('at_least', 100.0)),
)
