"""``./run grade EXERCISE -- COMMAND``: the command line of the grader.

Exit codes: 0 passed, 1 failed, 2 usage error or wrong exercise file, 3 undecided (no free port, or the machine was too
slow in three attempts), 130 interrupted.

It also works as a test for rostest: ``<test pkg="turtle_robotont" type="grade.py" args="EXERCISE -- COMMAND" .../>``.
"""
import argparse
import json
import os
import random
import shlex
import sys
from typing import Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple

from course_grader import sheet, usage
from course_grader.classes import grade_all, grade_merge, live
from course_grader.formats import exit_codes, harmless, systems, templates, terminal
from course_grader.formats.terminal import say
from course_grader.isolation import isolate, levels, limits
from course_grader.rules import exercise, reference, scoring
from course_grader.rules.exercise import Exercise
from course_grader.supervision.job import Attempted, Job
from course_grader.supervision.supervisor import EXTRA, RESULTS, Supervisor
from plain_support import course, create_whole, processes, unwritten, write_whole

GTEST_OUTPUT = '--gtest_output=xml:'
GRADE = 'EXERCISE'  # the command without a name of its own
DONE = exit_codes.OF_OUTCOME[scoring.PASSED]


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Do what the command line says; return the exit code."""
    try:
        options = parse(*_without_rostest(sys.argv[1:] if arguments is None else arguments))
        return int(options.run(options))
    finally:
        terminal.flush()


def parse(arguments: Sequence[str], junit: Optional[str] = None) -> argparse.Namespace:
    """Return the options of a command, of which ``run(options)`` does it; ``junit``: the file that rostest asks for.

    Options of GRADE have what was typed before ``--`` (``typed``), behind it (``command``, None without ``--``), and
    what of it is unknown. argparse.REMAINDER would include options in the command.
    """
    cut = list(arguments).index('--') if '--' in arguments else len(arguments)
    name, rest = _command(arguments[:cut])
    options, unknown = _parser().parse_known_args([name, *rest])
    if name != GRADE and unknown:
        options.parser.error(f'unrecognized arguments: {" ".join(unknown)}')
    options.typed, options.unknown, options.rostest = list(arguments[:cut]), unknown, junit
    options.command = list(arguments[cut + 1:]) if cut < len(arguments) else None
    return options


def _command(arguments: Sequence[str]) -> Tuple[str, List[str]]:
    """Return the name of the command, which may stand anywhere, and the other arguments."""
    for index, argument in enumerate(arguments):
        name, equals, value = argument.partition('=')
        if name in COMMANDS and name != GRADE:
            return name, [*([value] if equals else []), *arguments[:index], *arguments[index + 1:]]
    return GRADE, list(arguments)


def _parser() -> argparse.ArgumentParser:
    """Return the parser of all commands; their names begin with two dashes, so its own options would begin with +."""
    parser = argparse.ArgumentParser(prog='./run grade', prefix_chars='+', add_help=False)
    commands = parser.add_subparsers()
    for name, command in COMMANDS.items():
        one = commands.add_parser(name, description=command.description)
        command.add_options(one)
        one.set_defaults(run=command.run, parser=one)
    return parser


def _without_rostest(arguments: Sequence[str]) -> Tuple[List[str], Optional[str]]:
    """Return (arguments, FILE) without those that rostest appends: --gtest_output=xml:FILE, __name:=, __log:=."""
    arguments, junit = list(arguments), None
    if not any(argument.startswith(GTEST_OUTPUT) for argument in arguments):
        return arguments, junit  # __name and __log belong to the program
    while arguments and arguments[-1].startswith((GTEST_OUTPUT, '__name:=', '__log:=')):
        last = arguments.pop()
        junit = last[len(GTEST_OUTPUT):] if last.startswith(GTEST_OUTPUT) else junit
    return arguments, junit


def exercises() -> Dict[str, str]:
    """Return {name: path} of the exercises of the course, in the order of its steps."""
    return {name: str(path) for name, path in course.exercises(course.installed()).items()}


def load(path: str, student: str = '') -> Exercise:
    """Return the Exercise of a file, for a student, if this machine can grade it; raise ExerciseError or OSError."""
    loaded = exercise.load(path, student)
    if any(what == 'call' for what, _ in loaded.stimuli):
        from course_grader.attempt import service_types  # imports ROS, which other exercises do not need here
        service_types.check(loaded)
    if loaded.parameters:
        from course_grader.attempt import node_parameters
        node_parameters.check(loaded)
    return loaded


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.prog, parser.usage = './run grade', USAGE
    parser.epilog = 'Exit code: 0 passed, 1 failed, 2 usage error, 3 undecided.'
    parser.add_argument('exercise', help='name of an exercise, or path of your own YAML file; the names: '
                        + ', '.join(exercises()))
    parser.add_argument('--seed', type=int,
                        help='repeats the start and the stimuli of an earlier grading; default: random')
    parser.add_argument('--student', metavar='NAME', help='whose values an exercise has that differ from student to '
                        'student')
    parser.add_argument('--report', metavar='ADDRESS', default=os.environ.get(live.VARIABLE),
                        help='report the result to the live view of your class, under --student or your user name '
                        f'(default: {live.VARIABLE}, without which nothing is reported)')
    parser.add_argument('--real-time', action='store_true', help='grade at the speed of the wall clock')
    parser.add_argument('--packages', metavar='FOLDER', type=os.path.abspath,
                        help='where roslaunch and rosrun also look for packages; default: the workspaces that are '
                        "sourced in this terminal, and the package that holds the program's file")
    parser.add_argument('--format', choices=systems.FORMATS, metavar='FORMAT',
                        help='print and write what a system reads: ' + ', '.join(systems.FORMATS) + '; default: text, '
                        'or that of Classroom 50, Gradescope or VPL where one of them runs the grader')
    parser.add_argument('--junit', metavar='FILE', help='write junit.xml also to this file')
    parser.add_argument('--output', metavar='FOLDER', help='default: output/grades/EXERCISE')
    parser.add_argument('--limit', type=limits.seconds, metavar='SECONDS', help='longest wall-clock time of the '
                        f'grading (default: the time of the exercise + {EXTRA:g} s)')
    isolate.add_options(parser)


def _grade(options: argparse.Namespace) -> int:
    """Grade one program."""
    runner = systems.Runner(os.environ)
    options.format = options.format or systems.detect(runner)
    try:
        job = _job(options, runner)
    except (exercise.ExerciseError, systems.FormatError, usage.UsageError, live.ReportError, OSError) as error:
        return _wrong(error)
    processes.make_interruptible()
    try:
        with Supervisor() as supervisor:
            isolation, warning = isolate.choose(options)
            if warning:
                say(f'./run grade: {warning}', sys.stderr)
            job = job._replace(isolation=isolation)
            got = supervisor.grade(job, options.limit, lambda text: say(harmless.printed(text), sys.stderr))
        written = _written(options, runner, job, got, [*got.remarks, *filter(None, [warning])])
    except KeyboardInterrupt:
        say('./run grade: interrupted; all its processes have ended', sys.stderr)
        return exit_codes.INTERRUPTED
    except levels.TooWeak as error:
        say(f'./run grade: {error}', sys.stderr)
        return exit_codes.UNDECIDED
    except OSError as error:
        error.filename = error.filename or job.output
        say(f'./run grade: {unwritten(error, "choose another folder with --output")}', sys.stderr)
        return exit_codes.USAGE
    say(written.stdout)
    if options.report:
        _report(options, job.exercise, got.verdict)
    return written.code


def _job(options: argparse.Namespace, runner: systems.Runner) -> Job:
    """Return what is to be graded; raise the error of what is wrong with the options."""
    systems.check(options.format, runner)
    usage.check(options.typed, options.unknown, options.command, options.exercise)
    student = options.student or systems.student(options.format, runner)
    chosen = load(usage.find(options.exercise, exercises()), student)
    usage.check_student(chosen, student)
    live.check_address(options.report)
    if options.format not in systems.READ_SCORES:  # otherwise the program was not handed in
        usage.check_program(options.typed, options.command)
        if not options.packages:
            usage.check_package(options.typed, options.command)
    folder = os.path.abspath(options.output or os.path.join('output', 'grades', chosen.name))
    usage.check_folder(folder)
    seed = random.SystemRandom().randrange(1, 10_000) if options.seed is None else options.seed
    return Job(chosen, tuple(options.command), os.getcwd(), folder, seed, options.packages, options.real_time,
               sourced=usage.sourced_packages(os.environ))


def _written(options: argparse.Namespace, runner: systems.Runner, job: Job, got: Attempted, remarks: Sequence[str]
             ) -> systems.Written:
    """Write a grading in its format; raise OSError."""
    junit = options.rostest or options.junit
    if junit:
        with open(os.path.join(job.output, 'junit.xml'), 'rb') as file:
            write_whole(junit, file.read())
    files = ', '.join(name for name in RESULTS if os.path.exists(os.path.join(job.output, name)))
    notes = [*(f'  note: {remark}' for remark in remarks), f'  seed {job.seed}; {files} are in {job.output}']
    written = systems.rendered(options.format, systems.Grading(
        job.exercise, job.command, got.verdict, got.observed.seconds, job.output, notes, job.isolation.level), runner)
    systems.write(written)
    return written


def _report(options: argparse.Namespace, chosen: Exercise, verdict: scoring.Verdict) -> None:
    """Report a Verdict to the live view of the class."""
    try:
        live.report(options.report, options.student, chosen.name, verdict)
        text = 'reported to the live view of your class'
    except live.ReportError as error:
        text = f'the report to the live view did not arrive: {error}'
    say(harmless.printed(f'./run grade: {text}'), sys.stderr)


def _wrong(error: Exception) -> int:
    say(f'./run grade: {harmless.plain(str(error))}', sys.stderr)
    return exit_codes.USAGE


def _add_options_of_sheet(parser: argparse.ArgumentParser) -> None:
    parser.add_argument('student', nargs='?', help='the name, as that of the folder that is handed in')
    parser.add_argument('exercises', nargs='*', metavar='EXERCISE', help='name of an exercise, or path of a YAML file')


def _sheet(options: argparse.Namespace) -> int:
    """Print the exercise sheet of the course, or the tasks of a student."""
    if options.student is None:
        steps = course.steps(course.installed())
        files = [path for step in steps for path in course.exercises_of(step.folder)]
        say(sheet.markdown(steps, {path: exercise.load(path) for path in files}))
        return DONE
    if not options.exercises:
        options.parser.error('the exercises are missing, such as: ./run grade --sheet "Anna Berg" stop_at_x')
    try:
        tasks = [load(usage.find(name, exercises()), options.student) for name in options.exercises]
    except (exercise.ExerciseError, OSError) as error:
        return _wrong(error)
    say(harmless.plain(sheet.of_student(options.student, tasks)))
    return DONE


def _list(options: argparse.Namespace) -> int:
    """Print the exercises that can be graded without further options."""
    found = []
    for path in exercises().values():
        try:
            one = load(path)
            usage.check_student(one, None)
            found.append(one)
        except exercise.ExerciseError as error:
            say(f'./run grade: left out: {harmless.plain(str(error))}', sys.stderr)
        except usage.UsageError:
            continue
    if options.format == 'json':
        say(json.dumps([{'name': one.name, 'title': one.title, 'asks': one.asks} for one in found]))
    else:
        width = max(len(one.name) for one in found)
        say('\n'.join(f'{one.name:{width}}  {one.title}' for one in found))
    return DONE


def _checks(_options: argparse.Namespace) -> int:
    say(reference.text())
    return DONE


def _new(options: argparse.Namespace) -> int:
    """Write an exercise file to start from."""
    try:
        create_whole(options.file, templates.verbatim('exercise.yaml'))
    except FileExistsError:
        say(f'./run grade: {options.file} exists already; choose another name', sys.stderr)
        return exit_codes.USAGE
    except OSError as error:
        say(f'./run grade: {unwritten(error, "choose another folder")}', sys.stderr)
        return exit_codes.USAGE
    say(f'Wrote {options.file}. Edit it, and grade a program by it: ./run grade {shlex.quote(options.file)} -- PROGRAM')
    return DONE


class Command(NamedTuple):
    """A command of ./run grade: its description, what adds its options to a parser, and what does it."""

    description: str
    add_options: Callable[[argparse.ArgumentParser], object]
    run: Callable[[argparse.Namespace], int]


COMMANDS = {
    GRADE: Command("Grades a student's program (a Python file, an executable, or a rosrun or roslaunch command): "
                   'starts a master, a simulator and the program, and reports what was asked, what was seen, and the '
                   'score.', _add_options, _grade),
    '--all': Command((grade_all.__doc__ or '').split('\n\n')[0], grade_all.add_options,
                     lambda options: grade_all.run(options, exercises(), load)),
    '--merge': Command((grade_merge.__doc__ or '').split('\n\n', 1)[1], grade_merge.add_options, grade_merge.run),
    '--live': Command('Shows the gradings of a lab class on a page, while students type ./run grade --report ADDRESS. '
                      'Ctrl-C ends it.', live.add_options, live.run),
    '--sheet': Command('Prints the exercises of the course as Markdown, or the tasks of a student, with the values '
                       'that the exercise files draw for that name (vary).', _add_options_of_sheet, _sheet),
    '--list': Command('Lists the exercises that this machine can grade; json: with their tasks.', lambda parser:
                      parser.add_argument('format', nargs='?', choices=('text', 'json'), default='text'), _list),
    '--checks': Command('Prints what an exercise file may contain.', lambda parser: None, _checks),
    '--new': Command('Writes an exercise file to start from.', lambda parser:
                     parser.add_argument('file', metavar='FILE', help='the file to write'), _new),
}
USAGE = '''%(prog)s EXERCISE [--seed N] [--real-time] [--output FOLDER] -- COMMAND ...
       %(prog)s --all FOLDER ...   grades a class; see %(prog)s --all --help
       %(prog)s --merge DIR ...   joins results of --all; see %(prog)s --merge --help
       %(prog)s --live   shows the gradings of a lab class; see %(prog)s --live --help
       %(prog)s --sheet STUDENT EXERCISE ...   prints the tasks of a student, with their values
       %(prog)s --list   lists the exercises
       %(prog)s --new FILE   writes an exercise file; %(prog)s --checks lists what it may contain'''
