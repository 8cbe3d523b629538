"""./run grade --merge DIR ...: merges results of several machines or times.

Each DIR is an output folder of ./run grade --all, which may have graded a part of the class (--shard, --only). Of two
gradings of one submission the newer one counts, with --best the better one.
"""
import argparse
import os
import shutil
from typing import Dict, List, Tuple

from course_grader.classes import class_results, graded
from course_grader.classes.class_results import ClassError
from course_grader.classes.class_table import Class
from course_grader.classes.graded import NOT_GRADED, Graded, Unreadable
from course_grader.classes.marks import MarksError
from course_grader.classes.submissions import Submission
from course_grader.formats import harmless
from course_grader.formats.platforms import Origin
from course_grader.rules import scoring
from course_grader.supervision.supervisor import RESULTS


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument('parts', metavar='DIR', nargs='+', help='an output folder of ./run grade --all')
    class_results.add_options(parser)


def run(options: argparse.Namespace) -> int:
    """Merge; return the exit code, which is that of a class."""
    try:
        return _run(options)
    except (ClassError, MarksError, OSError) as error:
        return class_results.fail(error)


def _run(options: argparse.Namespace) -> int:
    parts = [(folder, *class_results.read(folder)) for folder in options.parts]
    class_results.check_output(options.output)
    students = sorted({name for _, _, names, *_ in parts for name in names})
    exercises = sorted({name for _, _, _, names, *_ in parts for name in names})
    class_results.check_weights(options.weights, exercises)
    best: Dict[Tuple[str, str, str], Graded] = {}
    for folder, _, _, _, found, _, _ in parts:
        for student, exercise, attempt, handed_in in found:
            one = _read(Submission(student, exercise, (), '', attempt=attempt, handed_in=handed_in), folder)
            key = student, exercise, attempt
            if key not in best or _rank(best[key], options) < _rank(one, options):
                best[key] = one
    results = [_moved(one, options.output) for _, one in sorted(best.items(), key=lambda entry: entry[0])]
    missing = [f'{one.submission.student}/{one.submission.exercise}' for one in results if not one.at]
    notes = [harmless.printed(f'Not graded in any part: {", ".join(missing)}')] if missing else []
    left_out = list(dict.fromkeys(one for *_, others, _ in parts for one in others))
    origin = Origin(parts[0][-1].platform, {name: number for part in parts for name, number in part[-1].ids.items()})
    return class_results.show(options, Class(parts[0][1], students, exercises, results, options.weights, left_out,
                                      origin),
                              results, notes)


def _read(submission: Submission, folder: str) -> Graded:
    own = graded.folder_of(submission, folder)
    try:
        return graded.load(submission, own)
    except Unreadable:
        return graded.undecided(submission, own, NOT_GRADED)


def _rank(one: Graded, options: argparse.Namespace) -> List[float]:
    decided = one.outcome in scoring.DECIDED
    return [decided, one.score if options.best else 0.0, one.at]


def _moved(one: Graded, output: str) -> Graded:
    """Return a grading with its files in the output folder."""
    target = graded.folder_of(one.submission, output)
    if one.at and os.path.realpath(target) != os.path.realpath(one.folder):
        os.makedirs(target, exist_ok=True)
        for name in (*RESULTS, graded.RECORD):
            path = os.path.join(one.folder, name)
            if os.path.isfile(path):
                shutil.copyfile(path, os.path.join(target, name))
            elif os.path.exists(os.path.join(target, name)):
                os.remove(os.path.join(target, name))
    return one._replace(folder=target)
