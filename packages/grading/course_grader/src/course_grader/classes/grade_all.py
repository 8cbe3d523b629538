"""./run grade --all FOLDER: grades the submissions of a class and writes a table of them.

submissions.py describes the folder. Everything is written into the output folder: scores.csv, grades.csv, index.html,
junit.xml, and STUDENT/EXERCISE/ with the files of each grading. Unchanged submissions are not graded again. Exit code:
0 all passed, 1 some failed, 2 wrong usage or the results could not be written, 3 some are undecided (and none failed),
130 interrupted.
"""
import argparse
import concurrent.futures
import datetime
import fnmatch
import os
import random
import sys
from typing import Callable, Dict, List, NamedTuple, Sequence, Set, TextIO, Tuple

from tqdm import tqdm

from course_grader.classes import class_grader, class_results, downloads, graded, remote, similarity, submissions
from course_grader.classes.class_grader import Work
from course_grader.classes.class_results import ClassError
from course_grader.classes.class_table import Class
from course_grader.classes.graded import NOT_GRADED, Graded, Unreadable
from course_grader.classes.marks import MarksError
from course_grader.classes.submissions import LeftOut, Submission
from course_grader.formats import exit_codes, harmless, platforms, systems
from course_grader.formats.platforms import Origin, WorksheetError
from course_grader.formats.terminal import say
from course_grader.isolation import isolate, levels, limits
from course_grader.rules import exercise, scoring
from course_grader.rules.exercise import Exercise
from course_grader.supervision.supervisor import EXTRA, INTERRUPTED, Supervisor
from plain_support import processes

NOBODY = 'me'  # the folder that our files for GitHub and GitLab once gave to every student
MAX_LINE = 200  # characters of the progress line of a grading
Load = Callable[[str], Exercise]


class Found(NamedTuple):
    """The content of a folder: {name: path} of the exercises, students, submissions, and what is not graded.

    ``origin``: the platform that it was downloaded from.
    """

    exercises: Dict[str, str]
    students: List[str]
    submissions: List[Submission]
    left_out: List[LeftOut]
    origin: Origin = Origin()


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument('folder', metavar='FOLDER', help='a folder with one subfolder per student, or a ZIP that '
                        'Moodle, Canvas or Gradescope gives to download; see docs/grading.md')
    parser.add_argument('--exercise', metavar='NAME',
                        help='FOLDER holds one program per student; grade all of them for this exercise')
    parser.add_argument('--jobs', type=limits.positive, default=os.cpu_count() or 1, metavar='N',
                        help='number of parallel gradings (default: one per CPU core, here %(default)s)')
    parser.add_argument('--seed', type=int, metavar='N',
                        help='repeats the starts and the stimuli of an earlier grading')
    parser.add_argument('--limit', type=limits.seconds, metavar='SECONDS', help='longest wall-clock time of one '
                        f'grading (default: the time of the exercise + {EXTRA:g} s)')
    parser.add_argument('--file-dates', action='store_true', help='for deadlines, take the dates of the files where '
                        'nothing else says when they were handed in; students can change these dates')
    parser.add_argument('--worksheet', metavar='FILE', help="the grading worksheet of Moodle's assignment, a CSV in "
                        'English, which says when each student has handed in')
    parser.add_argument('--again', action='store_true', help='grade also what is graded and has not changed')
    parser.add_argument('--only', metavar='PATTERN', action='append', help='grade only the submissions of these: '
                        "STUDENT or STUDENT/EXERCISE, such as 'anna' or '*/stop_at_x'; may be given several times")
    parser.add_argument('--shard', metavar='I/N', type=_shard, help='grade only each N-th submission, from the I-th '
                        'on; ./run grade --merge makes one result of all N')
    isolate.add_options(parser)
    remote.add_options(parser)
    class_results.add_options(parser)


def _shard(text: str) -> Tuple[int, int]:
    part, _, parts = text.partition('/')
    if not (part.isdigit() and parts.isdigit() and 1 <= int(part) <= int(parts)):
        raise argparse.ArgumentTypeError(f'{text!r} is not a part; write I/N, from 1/N to N/N, such as 1/4')
    return int(part), int(parts)


def run(options: argparse.Namespace, exercises: Dict[str, str], load: Load = exercise.load) -> int:
    """Grade a class; return the exit code. ``exercises``: {name: path}; ``load(path)`` returns one."""
    processes.make_interruptible()
    try:
        return _run(options, exercises, load)
    except (ClassError, MarksError, downloads.DownloadError, remote.RemoteError, submissions.SubmissionsError,
            exercise.ExerciseError, WorksheetError, OSError) as error:
        return class_results.fail(error)
    except levels.TooWeak as error:
        say(f'./run grade: {error}', sys.stderr)
        return exit_codes.UNDECIDED


def _run(options: argparse.Namespace, exercises: Dict[str, str], load: Load) -> int:
    remote.require_isolation(options)
    title = f'Grades of {os.path.basename(os.path.abspath(options.folder))}'
    found = _class(options, exercises, load)
    class_results.check_output(options.output)
    names = sorted({submission.exercise for submission in found.submissions})
    class_results.check_weights(options.weights, names)
    loaded = {name: load(found.exercises[name]) for name in names}
    chosen = _chosen(options, found.submissions)
    programs = {submission.program for submission in found.submissions}
    version = ' '.join([graded.version(), *isolate.line(options)])
    works = [_work(options, found, loaded, submission, programs, version) for submission in found.submissions]
    results = {} if options.again else _unchanged(works)
    if options.again:
        results = _unchanged([work for work in works if work.submission not in chosen])
    left = [work for work in works if work.submission in chosen and work.submission not in results]
    if len(left) < len(chosen):
        say(f'{len(chosen) - len(left)} of {len(chosen)} submissions have not changed since they were graded; --again '
            'grades them, too', _stream(options))
    fresh, interrupted = _grade(options, left)
    results.update({one.submission: one for one in fresh})
    for work in works:
        reason = INTERRUPTED if work.submission in chosen else NOT_GRADED
        results.setdefault(work.submission, graded.undecided(work.submission, work.folder, reason))
    code = class_results.show(options, Class(
        title, found.students, names, [results[submission] for submission in found.submissions], options.weights,
        found.left_out, found.origin, similarity.of_class(found.submissions)),
        [results[submission] for submission in chosen])
    return exit_codes.INTERRUPTED if interrupted else code


def _class(options: argparse.Namespace, exercises: Dict[str, str], load: Load = exercise.load) -> Found:
    if not os.path.exists(options.folder):
        raise ClassError(f'there is no folder {options.folder} (current folder: {os.getcwd()})')
    if not os.path.isdir(options.folder) and not options.folder.lower().endswith(downloads.ZIP):
        raise ClassError(f'{options.folder} is neither a folder nor a ZIP; to grade one program, type: '
                         f'./run grade EXERCISE -- {options.folder}')
    options.folder, unread, origin = downloads.folder_of_class(options.folder, options.output)
    exercises = {**exercises, **submissions.exercises_in(options.folder)}
    if options.exercise is None:
        found = Found(exercises, *submissions.find(options.folder, list(exercises), options.best,
                                                   of_map=lambda one: load(exercises[one]).of_map))
    else:
        name = os.path.splitext(os.path.basename(options.exercise))[0]
        path = options.exercise if os.path.isfile(options.exercise) else exercises.get(options.exercise)
        if path is None:
            raise ClassError(f'--exercise {options.exercise}: there is no such exercise; give the path of an '
                             f'exercise file, or one of {", ".join(sorted(exercises))}')
        asks_for_map = load(path).of_map
        flat = submissions.has_programs(options.folder)
        found = Found({name: os.path.abspath(path)}, *(
            submissions.find_flat(options.folder, name, lambda _: asks_for_map) if flat else
            submissions.find(options.folder, [name], options.best, name, lambda _: asks_for_map)))
    times = _worksheet_times(options, origin)
    return found._replace(left_out=[*found.left_out, *unread], origin=origin, submissions=[
        one._replace(handed_in=_handed_in(one, options, origin, times)) for one in found.submissions])


def _worksheet_times(options: argparse.Namespace, origin: Origin) -> Dict[str, str]:
    """Return {student: when they have handed in}, {} without a worksheet; raise ClassError or WorksheetError."""
    if not options.worksheet:
        return {}
    if origin.platform != platforms.MOODLE:
        raise ClassError(f'--worksheet {options.worksheet}: it belongs to what Moodle gives to download, with the same '
                         f'numbers in the names; {options.folder} has no such names')
    times = platforms.worksheet_times(options.worksheet)
    found = {student: times[number] for student, number in origin.ids.items() if number in times}
    if not found:
        raise ClassError(f'--worksheet {options.worksheet}: it has none of the students of {options.folder}; take the '
                         'worksheet of the same assignment')
    return found


def _handed_in(one: Submission, options: argparse.Namespace, origin: Origin, times: Dict[str, str]) -> str:
    """Return when a program was handed in, '' if nothing says so; ``times``: of all that a student has handed in."""
    path = os.path.relpath(one.program, os.path.abspath(options.folder)).replace(os.sep, '/')
    known = origin.times.get(path) or times.get(one.student, '')
    if known or not options.file_dates:
        return known
    return downloads.local_time(datetime.datetime.fromtimestamp(os.path.getmtime(one.program), datetime.timezone.utc))


def _chosen(options: argparse.Namespace, found: Sequence[Submission]) -> List[Submission]:
    """Return the submissions to grade, by --only and --shard."""
    part, parts = options.shard or (1, 1)
    chosen = sorted(found, key=lambda one: one.exercise)[part - 1::parts]  # so that each part has some of all exercises
    for pattern in options.only or ():
        if not any(_matches(submission, pattern) for submission in found):
            raise ClassError(f'--only {pattern}: there is no such submission. Write STUDENT or STUDENT/EXERCISE, such '
                             f'as {found[0].student} or {found[0].student}/{found[0].exercise}')
    return [submission for submission in chosen
            if not options.only or any(_matches(submission, pattern) for pattern in options.only)]


def _matches(submission: Submission, pattern: str) -> bool:
    student, slash, name = pattern.partition('/')
    return fnmatch.fnmatchcase(submission.student, student) and (
        not slash or fnmatch.fnmatchcase(submission.exercise, name))


def _work(options: argparse.Namespace, found: Found, loaded: Dict[str, Exercise], submission: Submission,
          programs: Set[str], version: str) -> Work:
    path = found.exercises[submission.exercise]
    seed = random.SystemRandom().randrange(1, 10_000) if options.seed is None else options.seed
    files = graded.files_of(submission, programs)
    one = loaded[submission.exercise]
    if one.varies and submission.student == NOBODY:
        raise ClassError(f'the values of {one.name} differ from student to student, and the folder {NOBODY} has no '
                         'name of one: call it as on the sheet. The files for GitHub and GitLab in '
                         'packages/grading/integrations do so')
    if one.varies:
        one = exercise.load(path, submission.student)
    return Work(submission, one, graded.folder_of(submission, options.output), seed,
                graded.fingerprint_of(submission, files, path, version, options.seed),
                _repeat(options, path, submission, seed, one.varies), options.limit, os.path.abspath(path), files,
                isolated_by=isolate.line(options))


def _repeat(options: argparse.Namespace, path: str, submission: Submission, seed: int, varies: bool
            ) -> Tuple[str, ...]:
    """Return the arguments of ./run grade that repeat a grading, without folders above that of the class."""
    root, shown = os.path.abspath(options.folder) + os.sep, options.folder
    if os.path.isabs(shown):
        shown = os.path.basename(os.path.abspath(shown))

    def bare(part: str) -> str:
        return os.path.join(shown, part[len(root):]) if part.startswith(root) else part
    own = os.path.abspath(path).startswith(root)
    command = [bare(part) for part in submission.command]
    packages = ['--packages', bare(submission.packages)] if submission.packages and not os.path.isabs(
        submission.command[0] if submission.command else '') else []
    student = ['--student', submission.student] if varies else []
    return (bare(os.path.abspath(path)) if own else submission.exercise, '--seed', str(seed), *student, *packages, '--',
            *command)


def _unchanged(works: Sequence[Work]) -> Dict[Submission, Graded]:
    """Return the gradings that have a verdict and have not changed."""
    known = {}
    for work in works:
        try:
            known[work.submission] = graded.load(work.submission, work.folder, work.fingerprint)
        except Unreadable:
            continue
        if known[work.submission].outcome not in scoring.DECIDED:
            del known[work.submission]
    return known


def _grade(options: argparse.Namespace, works: Sequence[Work]) -> Tuple[List[Graded], bool]:
    """Return (results, whether it was interrupted); show a progress bar on a terminal, otherwise a line for each."""
    results: List[Graded] = []
    stream = _stream(options)
    with tqdm(total=len(works), unit='submission', disable=not sys.stderr.isatty() or not works,
              dynamic_ncols=True) as bar:
        def done(one: Graded) -> None:
            results.append(one)
            bar.update()
            with bar.external_write_mode(stream):
                say(progress(one, len(results), len(works)), stream)
        try:
            if options.dask:
                remote.grade(options, works, done)
            elif works:
                with Supervisor() as supervisor:
                    isolation, warning = isolate.choose(options)
                    if warning:
                        say(f'./run grade: {warning}', sys.stderr)
                    works = [work._replace(isolation=isolation) for work in works]
                    class_grader.grade(works, concurrent.futures.ThreadPoolExecutor(options.jobs),
                                       class_grader.by(supervisor), done, supervisor.stop)
        except KeyboardInterrupt:
            say('Interrupted: all processes have ended; the table holds the gradings that were done.', stream)
            return results, True
    return results, False


def _stream(options: argparse.Namespace) -> TextIO:
    """Return the stream for the progress: standard error if another program reads the output."""
    return sys.stdout if options.format == systems.TEXT else sys.stderr


def progress(one: Graded, number: int, total: int) -> str:
    """Return the line for a grading, the ``number``-th of ``total``, with the reason that cost most points."""
    reason = one.verdict.main_reason()
    line = (f'[{number}/{total}] {one.submission.student} {one.submission.exercise}: {one.outcome}, '
            f'{one.score:g} of 100, {one.seconds:.1f} s')
    return harmless.printed((line + (f': {reason}' if reason else ''))[:MAX_LINE])
