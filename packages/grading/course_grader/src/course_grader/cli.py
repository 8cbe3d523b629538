"""``./run grade EXERCISE -- COMMAND``: the command line of the grader.

Exit codes: 0 passed, 1 failed, 2 usage error or wrong exercise file, 3 undecided (no free port, or the machine was too
slow in three attempts), 130 interrupted.

It also works as a test for rostest: ``<test pkg="turtle_robotont" type="grade.py" args="EXERCISE -- COMMAND" .../>``.
"""
import argparse
import difflib
import json
import os
import random
import shlex
import sys
import textwrap

import rospkg

from course_grader import live_report, sheet, usage
from course_grader.formats import exit_codes, harmless, systems, terminal
from course_grader.formats.terminal import say
from course_grader.isolation import isolate, levels, sourced, view
from course_grader.rules import exercise, new_exercise, reference, scoring
from course_grader.supervision.job import Job
from course_grader.supervision.supervisor import EXTRA, RESULTS, Supervisor, others_of
from plain_support import course, create_whole, processes, unwritten, write_whole

GTEST_OUTPUT = '--gtest_output=xml:'
SHEET_WIDTH = 80  # columns


def main(arguments=None):
    """Grade as the command line says; return the exit code."""
    try:
        return _main(arguments)
    finally:
        terminal.flush()


def _main(arguments):
    arguments, junit = _without_rostest(sys.argv[1:] if arguments is None else arguments)
    for option, run in OTHERS.items():
        if option in arguments[:_cut(arguments)]:
            return run([argument for argument in arguments if argument != option])
    options, unknown = _parse(arguments)
    place = systems.Place(os.environ)
    form = options.format or systems.detect(place)
    try:
        systems.check(form, place)
        usage.check(arguments[:_cut(arguments)], unknown, options.command, options.exercise)
        student = options.student or systems.student(form, place)
        chosen = load(_find(options.exercise), student)
        usage.check_student(chosen, student)
        live_report.check(options.report)
        if form not in systems.READ_SCORES:  # otherwise the program was not handed in
            usage.check_program(arguments[:_cut(arguments)], options.command)
            _check_package(arguments[:_cut(arguments)], options)
        folder = os.path.abspath(options.output or os.path.join('output', 'grades', chosen.name))
        _check_folder(folder)
    except (exercise.ExerciseError, systems.FormatError, usage.UsageError, live_report.AddressError,
            OSError) as error:
        say(f'./run grade: {harmless.plain(str(error))}', sys.stderr)
        return exit_codes.USAGE
    seed = random.SystemRandom().randrange(1, 10_000) if options.seed is None else options.seed
    processes.make_interruptible()
    job = Job(chosen, tuple(options.command), os.getcwd(), folder, seed, options.packages, options.real_time,
              sourced=_sourced(os.environ))
    try:
        with Supervisor() as supervisor:
            isolation, warning = isolate.choose(options)
            if warning:
                say(f'./run grade: {warning}', sys.stderr)
            got = supervisor.grade(job._replace(isolation=isolation), options.limit,
                                   lambda text: say(harmless.printed(text), sys.stderr))
        if junit or options.junit:
            with open(os.path.join(folder, 'junit.xml'), 'rb') as file:
                write_whole(junit or options.junit, file.read())
        files = ', '.join(name for name in RESULTS if os.path.exists(os.path.join(folder, name)))
        notes = [*(f'  note: {remark}' for remark in (*got.remarks, *filter(None, [warning]))),
                 f'  seed {seed}; {files} are in {folder}']
        written = systems.rendered(form, systems.Grading(chosen, job.command, got.verdict, got.observed.seconds, folder,
                                                         notes, isolation.level), place)
        systems.write(written)
    except KeyboardInterrupt:
        say('./run grade: interrupted; all its processes have ended', sys.stderr)
        return exit_codes.INTERRUPTED
    except levels.TooWeak as error:
        say(f'./run grade: {error}', sys.stderr)
        return exit_codes.UNDECIDED
    except OSError as error:
        error.filename = error.filename or folder
        say(f'./run grade: {unwritten(error, "choose another folder with --output")}', sys.stderr)
        return exit_codes.USAGE
    say(written.stdout)
    _report(options, chosen, got.verdict)
    return written.code


def _check_folder(folder):
    """Raise UsageError if results would replace files that no grading has written."""
    others = others_of(folder)
    if others:
        raise usage.UsageError(f'{folder} has {", ".join(others)}, which this would replace, and no results of a '
                               'grading. Choose another folder with --output')


def _report(options, chosen, decided):
    """Report a Verdict to the live view of the class, if the student asks for it."""
    if options.report:
        trouble = live_report.send(options.report, options.student, chosen.name, decided)
        say(harmless.printed('./run grade: ' + (f'the report to the live view did not arrive: {trouble}' if trouble else
                                                'reported to the live view of your class')), sys.stderr)


def exercises():
    """Return {name: path} of the exercises of the course, in the order of its steps."""
    return {name: str(path) for name, path in course.exercises(course.installed()).items()}


def load(path, student=''):
    """Return the Exercise of a file, for a student, if this machine can grade it; raise ExerciseError or OSError."""
    loaded = exercise.load(path, student)
    if any(what == 'call' for what, _ in loaded.stimuli):
        from course_grader.attempt import service_types  # imports ROS, which other exercises do not need here
        service_types.check(loaded)
    if loaded.parameters:
        from course_grader.attempt import node_parameters
        node_parameters.check(loaded)
    return loaded


def _sheet(arguments):
    """Print the exercise sheet of the course, or the tasks of a student; return the exit code."""
    parser = argparse.ArgumentParser(prog='./run grade --sheet', description='Prints the exercises of the course as '
                                     'Markdown, or the tasks of a student, with the values that the exercise files '
                                     'draw for that name (vary).')
    parser.add_argument('student', nargs='?', help='the name, as that of the folder that is handed in')
    parser.add_argument('exercises', nargs='*', metavar='EXERCISE', help='name of an exercise, or path of a YAML file')
    options = parser.parse_args(arguments)
    if options.student is None:
        steps = course.steps(course.installed())
        files = [path for step in steps for path in course.exercises_of(step.folder)]
        say(sheet.markdown(steps, {path: exercise.load(path) for path in files}))
        return exit_codes.OF_OUTCOME[scoring.PASSED]
    if not options.exercises:
        parser.error('the exercises are missing, such as: ./run grade --sheet "Anna Berg" stop_at_x')
    try:
        tasks = [load(_find(name), options.student) for name in options.exercises]
    except (exercise.ExerciseError, OSError) as error:
        say(f'./run grade: {harmless.plain(str(error))}', sys.stderr)
        return exit_codes.USAGE
    say(harmless.plain(f'{options.student}\n\n' + '\n\n'.join(
        '\n'.join([f'{one.name}: {one.title}', *textwrap.wrap(one.asks, SHEET_WIDTH)]) for one in tasks)))
    return exit_codes.OF_OUTCOME[scoring.PASSED]


def _sourced(environment):
    """Return the Sourced packages of the terminal, without ROS and this repository."""
    entries = sourced.folders_in(environment, sourced.PACKAGE_PATH, 'ROS_PACKAGE_PATH')
    prefixes = sourced.folders_in(environment, sourced.PREFIX_PATH, 'CMAKE_PREFIX_PATH')
    others = [*view.SYSTEM, view.REPOSITORY]
    known = rospkg.RosPack(sourced.outside(entries, others))
    packages = [(name, known.get_path(name)) for name in sorted(known.list())]
    return sourced.Sourced(tuple((name, folder) for name, folder in packages if sourced.outside([folder], others)),
                           tuple(sourced.outside(prefixes, view.SYSTEM)))


def _check_package(arguments, options):
    """Raise UsageError if rosrun or roslaunch would not find the package of a command."""
    program, *words = options.command
    words = [word for word in words if not word.startswith('-')]
    if program not in ('rosrun', 'roslaunch') or not words or os.path.isfile(words[0]) or options.packages:
        return
    known = [*rospkg.RosPack().list(), *(name for name, _ in _sourced(os.environ).packages)]
    if words[0] not in known:
        close = difflib.get_close_matches(words[0], known, 1)
        raise usage.UsageError(
            f'there is no package {words[0]} in the workspaces of this terminal.'
            + (f' Did you mean {close[0]}?' if close else '') + ' Type this, with the folder of your workspace:\n'
            f'  source ~/ros_ws/devel/setup.bash\n  {usage.line(arguments, options.command)}')


def _find(name):
    """Return the path of an exercise, given by name or as a file."""
    known = exercises()
    if name in known:
        return known[name]
    if os.path.exists(name):
        return name
    close = difflib.get_close_matches(name, known, 1)
    raise exercise.ExerciseError(f'there is no exercise {name!r}; give the path of an exercise file, or one of '
                                 f'{", ".join(known)}' + (f'. Did you mean {close[0]}?' if close else ''))


def _parse(arguments):
    parser = argparse.ArgumentParser(
        prog='./run grade',
        usage='%(prog)s EXERCISE [--seed N] [--real-time] [--output FOLDER] -- COMMAND ...\n'
        '       %(prog)s --all FOLDER ...   grades a class; see %(prog)s --all --help\n'
        '       %(prog)s --merge DIR ...   joins results of --all; see %(prog)s --merge --help\n'
        '       %(prog)s --live   shows the gradings of a lab class; see %(prog)s --live --help\n'
        '       %(prog)s --sheet STUDENT EXERCISE ...   prints the tasks of a student, with their values\n'
        '       %(prog)s --list   lists the exercises\n'
        '       %(prog)s --new FILE   writes an exercise file; %(prog)s --checks lists what it may contain',
        description="Grades a student's program (a Python file, an executable, or a rosrun or roslaunch command): "
        'starts a master, a simulator and the program, and reports what was asked, what was seen, and the score.',
        epilog='Exit code: 0 passed, 1 failed, 2 usage error, 3 undecided.')
    parser.add_argument('exercise', help='name of an exercise, or path of your own YAML file; the names: '
                        + ', '.join(exercises()))
    parser.add_argument('--list', action=_List, nargs='?', choices=('text', 'json'), const='text', dest='listed',
                        help='list the exercises that this machine can grade, and end; json: with their tasks')
    parser.add_argument('--checks', action=_Checks, nargs=0, help='print what an exercise file may contain, and end')
    parser.add_argument('--new', action=_New, metavar='FILE', help='write an exercise file to start from, and end')
    parser.add_argument('--seed', type=int,
                        help='repeats the start and the stimuli of an earlier grading; default: random')
    parser.add_argument('--student', metavar='NAME', help='whose values an exercise has that differ from student to '
                        'student')
    parser.add_argument('--report', metavar='ADDRESS', default=os.environ.get(live_report.VARIABLE),
                        help='report the result to the live view of your class, under --student or your user name '
                        f'(default: {live_report.VARIABLE}, without which nothing is reported)')
    parser.add_argument('--real-time', action='store_true', help='grade at the speed of the wall clock')
    parser.add_argument('--packages', metavar='FOLDER', type=os.path.abspath,
                        help='where roslaunch and rosrun also look for packages; default: the workspaces that are '
                        "sourced in this terminal, and the package that holds the program's file")
    parser.add_argument('--format', choices=systems.FORMATS, metavar='FORMAT',
                        help='print and write what a system reads: ' + ', '.join(systems.FORMATS) + '; default: text, '
                        'or that of Classroom 50, Gradescope or VPL where one of them runs the grader')
    parser.add_argument('--junit', metavar='FILE', help='write junit.xml also to this file')
    parser.add_argument('--output', metavar='FOLDER', help='default: output/grades/EXERCISE')
    parser.add_argument('--limit', type=usage.seconds, metavar='SECONDS', help='longest wall-clock time of the grading '
                        f'(default: the time of the exercise + {EXTRA:g} s)')
    isolate.add_options(parser)
    cut = _cut(arguments)
    options, unknown = parser.parse_known_args(arguments[:cut])
    options.command = arguments[cut + 1:] if cut < len(arguments) else None
    return options, unknown


class _List(argparse.Action):
    """--list: print the exercises that can be graded without further options."""

    def __call__(self, parser, namespace, values, option_string=None):
        found = []
        for path in exercises().values():
            try:
                found.append(load(path))
                usage.check_student(found[-1], None)
            except exercise.ExerciseError as error:
                say(f'./run grade: left out: {harmless.plain(str(error))}', sys.stderr)
            except usage.UsageError:
                found.pop()
        if values == 'json':
            say(json.dumps([{'name': one.name, 'title': one.title, 'asks': one.asks} for one in found]))
        else:
            width = max(len(one.name) for one in found)
            say('\n'.join(f'{one.name:{width}}  {one.title}' for one in found))
        parser.exit(0)


class _Checks(argparse.Action):
    """--checks: print what an exercise file may contain."""

    def __call__(self, parser, *_):
        say(reference.text())
        parser.exit(0)


class _New(argparse.Action):
    """--new FILE: write an exercise file to start from."""

    def __call__(self, parser, namespace, values, option_string=None):
        try:
            create_whole(values, new_exercise.TEXT)
        except FileExistsError:
            parser.exit(exit_codes.USAGE, f'./run grade: {values} exists already; choose another name\n')
        except OSError as error:
            parser.exit(exit_codes.USAGE, f'./run grade: {unwritten(error, "choose another folder")}\n')
        say(f'Wrote {values}. Edit it, and grade a program by it: ./run grade {shlex.quote(values)} -- PROGRAM')
        parser.exit(0)


def _without_rostest(arguments):
    """Return (arguments, FILE) without those that rostest appends: --gtest_output=xml:FILE, __name:=, __log:=."""
    arguments, junit = list(arguments), None
    if not any(argument.startswith(GTEST_OUTPUT) for argument in arguments):
        return arguments, junit  # __name and __log belong to the program
    while arguments and arguments[-1].startswith((GTEST_OUTPUT, '__name:=', '__log:=')):
        last = arguments.pop()
        junit = last[len(GTEST_OUTPUT):] if last.startswith(GTEST_OUTPUT) else junit
    return arguments, junit


def _cut(arguments):
    """Return the index of the command; argparse.REMAINDER would include the options in it."""
    return arguments.index('--') if '--' in arguments else len(arguments)


def _merge(arguments):
    from course_grader.classes import grade_merge  # only here: its imports would delay the grading of one program
    return grade_merge.main(arguments)


def _live(arguments):
    from course_grader.classes import live
    return live.main(arguments)


def _all(arguments):
    from course_grader.classes import grade_all
    return grade_all.main(arguments, exercises(), load)


OTHERS = {'--merge': _merge, '--all': _all, '--sheet': _sheet, '--live': _live}  # options that are commands
