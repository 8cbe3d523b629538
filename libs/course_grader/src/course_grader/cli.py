"""``./run grade EXERCISE -- COMMAND``: the command line of the grader.

Exit codes: 0 passed, 1 failed, 2 usage error or wrong exercise file, 3 undecided (no free port, or the machine was too
slow in three attempts), 130 interrupted.

It is a test for rostest, too: ``<test pkg="turtle_robotont" type="grade.py" args="EXERCISE -- COMMAND" .../>``.
"""
import argparse
import os
import random
import sys

import rospkg

from course_grader.classes import grade_all
from course_grader.formats import exit_codes, harmless, systems
from course_grader.rules import exercise
from course_grader.supervision.job import Job
from course_grader.supervision.supervisor import Supervisor
from kinematic_core.files import write_whole
from process_support import processes

GTEST_OUTPUT = '--gtest_output=xml:'


def main(arguments=None):
    """Grade as the command line says; return the exit code."""
    arguments, junit = _without_rostest(sys.argv[1:] if arguments is None else arguments)
    if '--all' in arguments[:_cut(arguments)]:
        return grade_all.main([argument for argument in arguments if argument != '--all'], exercises())
    options = _parse(arguments)
    place = systems.Place(os.environ)
    form = options.format or systems.detect(place)
    try:
        systems.check(form, place)
        chosen = exercise.load(_find(options.exercise))
    except (exercise.ExerciseError, systems.FormatError, OSError) as error:
        print(f'./run grade: {error}', file=sys.stderr)
        return exit_codes.USAGE
    seed = random.SystemRandom().randrange(1, 10_000) if options.seed is None else options.seed
    folder = os.path.abspath(options.output or os.path.join('output', 'grades', chosen.name))
    processes.make_interruptible()
    job = Job(chosen, tuple(options.command), os.getcwd(), folder, seed, options.packages, options.real_time)
    try:
        with Supervisor() as supervisor:
            got = supervisor.grade(job, say=lambda text: print(harmless.printed(text), file=sys.stderr))
        if junit or options.junit:
            with open(os.path.join(folder, 'junit.xml'), 'rb') as file:
                write_whole(junit or options.junit, file.read())
        notes = [*(f'  note: {remark}' for remark in got.remarks),
                 f'  seed {seed}; path.png, result.json, junit.xml and output.txt are in {folder}']
        written = systems.rendered(form, systems.Grading(chosen, job.command, got.verdict, got.observed.seconds, folder,
                                                         notes), place)
        systems.write(written)
    except KeyboardInterrupt:
        print('./run grade: interrupted; all its processes have ended', file=sys.stderr)
        return exit_codes.INTERRUPTED
    except OSError as error:
        print(f'./run grade: {error.filename or folder} cannot be written: {error.strerror}. Choose another folder '
              'with --output', file=sys.stderr)
        return exit_codes.USAGE
    print(written.stdout)
    return written.code


def exercises():
    """Return {name: path} of the exercises that come with the package."""
    folder = os.path.join(rospkg.RosPack().get_path('turtle_robotont'), 'exercises')
    return {entry[:-len('.yaml')]: os.path.join(folder, entry) for entry in sorted(os.listdir(folder))
            if entry.endswith('.yaml')}


def _find(name):
    """Return the path of an exercise, given by name or as a file."""
    known = exercises()
    if name in known:
        return known[name]
    if os.path.exists(name):
        return name
    raise exercise.ExerciseError(f'there is no exercise {name!r}; give the path of an exercise file, or one of '
                                 f'{", ".join(known)}')


def _parse(arguments):
    parser = argparse.ArgumentParser(
        prog='./run grade',
        usage='%(prog)s EXERCISE [--seed N] [--real-time] [--output FOLDER] -- COMMAND ...\n'
        '       %(prog)s --all FOLDER ...   grades a class; see %(prog)s --all --help',
        description="Grades a student's program (a Python file, an executable, or a rosrun or roslaunch command): "
        'starts a master, a simulator and the program, and reports what was asked, what was seen, and the score.',
        epilog='Exit code: 0 passed, 1 failed, 2 usage error, 3 undecided.')
    parser.add_argument('exercise', help='name of an exercise, or path of your own YAML file; the names: '
                        + ', '.join(exercises()))
    parser.add_argument('--seed', type=int,
                        help='repeats the start and the stimuli of an earlier grading; default: random')
    parser.add_argument('--real-time', action='store_true', help='grade at the speed of the wall clock')
    parser.add_argument('--packages', metavar='FOLDER', type=os.path.abspath,
                        help="where roslaunch and rosrun also look for packages; default: the package that holds the "
                        "program's file")
    parser.add_argument('--format', choices=systems.FORMATS, metavar='FORMAT',
                        help='print and write what a system reads: ' + ', '.join(systems.FORMATS) + '; default: text, '
                        'or that of Classroom 50, Gradescope or VPL where one of them runs the grader')
    parser.add_argument('--junit', metavar='FILE', help='write junit.xml also to this file')
    parser.add_argument('--output', metavar='FOLDER', help='default: output/grades/EXERCISE')
    cut = _cut(arguments)
    options = parser.parse_args(arguments[:cut])
    options.command = arguments[cut + 1:]
    return options


def _without_rostest(arguments):
    """Return (arguments, FILE) without what rostest adds at their end: --gtest_output=xml:FILE, __name:=, __log:=."""
    arguments, junit = list(arguments), None
    if not any(argument.startswith(GTEST_OUTPUT) for argument in arguments):
        return arguments, junit  # a name or a log at the end is the program's
    while arguments and arguments[-1].startswith((GTEST_OUTPUT, '__name:=', '__log:=')):
        last = arguments.pop()
        junit = last[len(GTEST_OUTPUT):] if last.startswith(GTEST_OUTPUT) else junit
    return arguments, junit


def _cut(arguments):
    """Return the index of the command; argparse.REMAINDER would take the options as a part of it."""
    return arguments.index('--') if '--' in arguments else len(arguments)
