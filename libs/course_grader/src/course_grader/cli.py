"""``./run grade EXERCISE -- COMMAND``: the command line of the grader.

Exit codes: 0 passed, 1 failed, 2 usage error or wrong exercise file, 3 undecided (no free port, or the machine was too
slow in three attempts), 130 interrupted.

It is a test for rostest, too: ``<test pkg="turtle_robotont" type="grade.py" args="EXERCISE -- COMMAND" .../>``.
"""
import argparse
import os
import random
import sys
import time
import traceback

import rospkg

from course_grader.attempt.session import Session, SessionError
from course_grader.classes import grade_all
from course_grader.formats import exit_codes, report
from course_grader.isolation import sandbox
from course_grader.rules import exercise, scoring
from course_grader.rules.observation import Observed
from kinematic_core.files import write_whole
from process_support import processes

REPEATS = 2  # of a grading that could not be decided: the machine may have stood still
WORTH_REPEATING = 45.0  # [s] of wall time; what took longer is not repeated
GTEST_OUTPUT = '--gtest_output=xml:'


def main(arguments=None):
    """Grade as the command line says; return the exit code."""
    arguments, junit = _without_rostest(sys.argv[1:] if arguments is None else arguments)
    del sys.argv[1:]  # rospy would take the command's names for this node's
    if '--all' in arguments[:_cut(arguments)]:
        return grade_all.main([argument for argument in arguments if argument != '--all'],
                              [sys.executable, os.path.abspath(sys.argv[0])], exercises())
    options = _parse(arguments)
    options.junit = junit or options.junit
    try:
        chosen = exercise.load(_find(options.exercise))
    except (exercise.ExerciseError, OSError) as error:
        print(f'./run grade: {error}', file=sys.stderr)
        return exit_codes.USAGE
    seed = random.SystemRandom().randrange(1, 10_000) if options.seed is None else options.seed
    folder = os.path.abspath(options.output or os.path.join('output', 'grades', chosen.name))
    command = options.command
    processes.make_interruptible()
    try:
        os.makedirs(folder, exist_ok=True)
        start = time.monotonic()
        session, decided = _grade(chosen, command, seed, folder, options)
        if session and session.busy and session.lockstep:
            print(f'{session.busy} never sleeps (is there a rate.sleep() in its loop?). Grading again in real time.')
            _grade_again(options, seed, folder, ['--real-time', '--busy', session.busy])
        if decided.outcome == scoring.UNDECIDED and options.busy and session.flooded:
            decided = decided._replace(outcome=scoring.FAILED, objections=[
                f'{options.busy} never sleeps, so the simulator gets no time; is there a rate.sleep() in its loop?'])
        slow = decided.outcome == scoring.UNDECIDED and not session.observed.kept_up
        if slow and options.repeats > 0 and time.monotonic() - start < WORTH_REPEATING:
            print(f'Grading again, because {decided.objections[0]}')
            last = ['--real-time'] if options.repeats == 1 and session.lockstep else []  # should it be the lockstep
            _grade_again(options, seed, folder, [*last, '--repeats', str(options.repeats - 1)])
        report.write(folder, chosen, session.observed if session else Observed(), decided, command, seed)
        if options.junit:
            with open(os.path.join(folder, 'junit.xml'), 'rb') as file:
                write_whole(options.junit, file.read())
    except KeyboardInterrupt:
        print('./run grade: interrupted; all its processes have ended', file=sys.stderr)
        return exit_codes.INTERRUPTED
    except OSError as error:
        print(f'./run grade: {folder} cannot be written: {error.strerror}. Choose another folder with --output',
              file=sys.stderr)
        return exit_codes.USAGE
    print(report.text(chosen, decided))
    for remark in session.remarks if session else []:
        print(f'  note: {remark}')
    print(f'  seed {seed}; path.png, result.json, junit.xml and output.txt are in {folder}')
    return exit_codes.OF_OUTCOME[decided.outcome]


def _grade_again(options, seed, folder, others):
    """Start the program again: a process can have only one rospy node in its life."""
    sys.stdout.flush()
    kept = [f'--{name}={value}' for name in ('junit', 'busy', 'packages')
            for value in [getattr(options, name)] if value is not None]
    os.execv(sys.executable, [sys.executable, sys.argv[0], options.exercise, f'--seed={seed}', f'--output={folder}',
                              *kept, *(['--real-time'] if options.real_time else []), *others, '--', *options.command])


def _grade(chosen, command, seed, folder, options):
    """Return (Session or None, Verdict); raise OSError when the folder cannot be used."""
    try:
        session = Session(chosen, command, seed, folder, options.real_time, options.packages)
    except sandbox.CommandError as error:
        return None, scoring.Verdict(scoring.FAILED, 0.0, [], [str(error)])
    try:
        return session, session.run()
    except SessionError as error:
        return session, scoring.Verdict(scoring.UNDECIDED, 0.0, [], [str(error)])
    except OSError:
        raise
    except Exception as error:  # whatever it is, it is not the student's fault; Python's exit code 1 would say so
        traceback.print_exc()
        said = f'the grader itself failed: {type(error).__name__}: {error}'
        return session, scoring.Verdict(scoring.UNDECIDED, 0.0, [], [said])


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
    parser.add_argument('--busy', help=argparse.SUPPRESS)  # the nodes that never rested in the first try
    parser.add_argument('--repeats', type=int, default=REPEATS, help=argparse.SUPPRESS)  # that are left
    parser.add_argument('--packages', metavar='FOLDER', type=os.path.abspath,
                        help="where roslaunch and rosrun also look for packages; default: the package that holds the "
                        "program's file")
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
