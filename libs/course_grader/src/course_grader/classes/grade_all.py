"""./run grade --all FOLDER: grades the submissions of a class and writes a table of them.

The form of the folder: submissions.py. Everything is written into the output folder: scores.csv, index.html, junit.xml,
and STUDENT/EXERCISE/ with the files of each grading. Exit code: 0 all passed, 1 some failed, 2 wrong usage or the
results could not be written, 3 some are undecided (and none failed), 130 interrupted.
"""
import argparse
import errno
import os
import sys
import tempfile
from typing import Callable, Dict, List, Sequence, Tuple

from tqdm import tqdm

from course_grader.classes import class_grader, submissions
from course_grader.classes.class_grader import ClassGrader, Graded
from course_grader.classes.submissions import Submission
from course_grader.formats import class_report, exit_codes, harmless, systems
from course_grader.rules import exercise, scoring
from course_grader.rules.exercise import Exercise
from course_grader.supervision.supervisor import EXTRA, Supervisor
from process_support import processes

OUTPUT = os.path.join('output', 'grades')
LONGEST = 200  # characters of the line for a grading


class GradeAllError(Exception):
    """The class cannot be graded or its table cannot be written; the text says why and what to do."""


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    made = argparse.ArgumentParser(prog='./run grade --all', description=(__doc__ or '').split('\n\n')[0])
    made.add_argument('folder', metavar='FOLDER', help='a folder with one subfolder per student; see docs/grading.md')
    made.add_argument('--exercise', metavar='NAME',
                      help='FOLDER holds one program per student; grade all of them for this exercise')
    made.add_argument('--jobs', type=int, default=os.cpu_count() or 1, metavar='N',
                      help='number of parallel gradings (default: one per CPU core, here %(default)s)')
    made.add_argument('--output', metavar='DIR', default=OUTPUT, help='folder for the results (default: %(default)s)')
    made.add_argument('--seed', type=int, metavar='N', help='repeats the starts and the stimuli of an earlier grading')
    made.add_argument('--limit', type=float, metavar='SECONDS', help='longest wall-clock time of one grading '
                      f'(default: the time of the exercise + {EXTRA:g} s)')
    return made


def main(arguments: Sequence[str], exercises: Dict[str, str], load: Callable[[str], Exercise] = exercise.load) -> int:
    """Grade a class; return the exit code. ``exercises``: {name: path}; ``load(path)`` returns one."""
    options = parser().parse_args(arguments)
    if options.jobs < 1:
        parser().error(f'--jobs is {options.jobs}; it must be 1 or more')
    if options.limit is not None and not options.limit > 0.0:
        parser().error(f'--limit is {options.limit:g} s; it must be above 0')
    processes.make_interruptible()
    try:
        return _run(options, exercises, load)
    except (GradeAllError, submissions.SubmissionsError, exercise.ExerciseError) as error:
        print(f'./run grade: {error}', file=sys.stderr)
    except OSError as error:
        print(f'./run grade: {_advice(error)}', file=sys.stderr)
    return exit_codes.USAGE


def _run(options: argparse.Namespace, exercises: Dict[str, str], load: Callable[[str], Exercise]) -> int:
    exercises, students, found, left_out = _class(options, exercises)
    _check_output(options.output)
    names = sorted({submission.exercise for submission in found})
    loaded = {name: load(exercises[name]) for name in names}
    with Supervisor() as supervisor:
        grader = ClassGrader(supervisor, loaded, options.output, options.limit, options.seed)
        results, interrupted = _grade(grader, found, options)
    results += [class_grader.interrupted(submission, options.output) for submission in found
                if submission not in {graded.submission for graded in results}]
    results.sort(key=lambda graded: found.index(graded.submission))
    _print_table(students, names, results)
    if left_out:
        print(harmless.printed(f'Left out, because no exercise has such a name: {", ".join(left_out)}'))
    title = f'Grades of {os.path.basename(os.path.abspath(options.folder))}'
    class_report.write(options.output, title, students, names, results)
    print('Table: ' + ', '.join(os.path.join(options.output, name) for name in class_report.FILES))
    outcomes = {graded.outcome for graded in results}
    worst = next((outcome for outcome in (scoring.FAILED, scoring.UNDECIDED) if outcome in outcomes), scoring.PASSED)
    return exit_codes.INTERRUPTED if interrupted else exit_codes.OF_OUTCOME[worst]


def _class(options: argparse.Namespace, exercises: Dict[str, str]
           ) -> Tuple[Dict[str, str], List[str], List[Submission], List[str]]:
    """Return ({name: path} of the exercises, students, submissions, programs left out)."""
    if not os.path.isdir(options.folder):
        raise GradeAllError(f'there is no folder {options.folder} (current folder: {os.getcwd()})'
                            if not os.path.exists(options.folder) else
                            f'{options.folder} is not a folder; to grade one program, type: '
                            f'./run grade EXERCISE -- {options.folder}')
    exercises = {**exercises, **submissions.exercises_in(options.folder)}
    if options.exercise is None:
        return (exercises, *submissions.find(options.folder, list(exercises)))
    name = os.path.splitext(os.path.basename(options.exercise))[0]
    path = options.exercise if os.path.isfile(options.exercise) else exercises.get(options.exercise)
    if path is None:
        raise GradeAllError(f'--exercise {options.exercise}: there is no such exercise; give the path of an '
                            f'exercise file, or one of {", ".join(sorted(exercises))}')
    return ({name: os.path.abspath(path)}, *submissions.find_flat(options.folder, name))


def _check_output(folder: str) -> None:
    """Raise OSError unless files can be written into a folder; better now than after the gradings."""
    os.makedirs(folder, exist_ok=True)
    with tempfile.TemporaryFile(dir=folder) as file:
        file.write(b'.' * 4096)


def _grade(grader: ClassGrader, found: Sequence[Submission], options: argparse.Namespace
           ) -> Tuple[List[Graded], bool]:
    """Return (results, whether it was interrupted); show a bar on a terminal, else a line for each."""
    results: List[Graded] = []
    with tqdm(total=len(found), unit='submission', disable=not sys.stderr.isatty(), dynamic_ncols=True) as bar:
        def done(graded: Graded) -> None:
            results.append(graded)
            bar.update()
            bar.write(progress(graded, len(results), len(found)))
            sys.stdout.flush()
        try:
            grader.grade(found, options.jobs, done)
        except KeyboardInterrupt:
            bar.write('Interrupted: all processes have ended; the table holds the gradings that were done.')
            return results, True
    return results, False


def progress(graded: Graded, number: int, total: int) -> str:
    """Return the line for a grading, the ``number``-th of ``total``, with the reason that cost most points."""
    said = systems.first_reason(graded.verdict) if graded.verdict else (*graded.reasons, '')[0]
    line = (f'[{number}/{total}] {graded.submission.student} {graded.submission.exercise}: {graded.outcome}, '
            f'{graded.score:g} of 100, {graded.seconds:.1f} s')
    return harmless.printed((line + (f': {said}' if said else ''))[:LONGEST])


def _print_table(students: Sequence[str], names: Sequence[str], results: Sequence[Graded]) -> None:
    rows = class_report.cells(students, names, results)
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    for row in rows:
        print(harmless.printed('  '.join(cell.ljust(width) if place == 0 else cell.rjust(width)
                                         for place, (cell, width) in enumerate(zip(row, widths))).rstrip()))


def _advice(error: OSError) -> str:
    """Return what went wrong with a file and what to do."""
    text = f'{error.filename or "the results"}: {error.strerror or error}'
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        return f'{text}. The disk is full: make room, or choose another folder with --output DIR'
    if error.errno in (errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOTDIR, errno.EEXIST, errno.ENOENT):
        return f'{text}. Choose another folder with --output DIR'
    return text
