"""Finds wrong usage of ./run grade before anything starts; errors give the line to type."""
import argparse
import difflib
import math
import os
import shlex

from course_grader.isolation import sandbox


class UsageError(ValueError):
    """The command line is wrong; the text says what to type."""


def seconds(text):
    """Return a typed time [s], above 0."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f'it is {text}; it must be a number above 0')
    return value


def check(arguments, unknown, command, exercise):
    """Raise UsageError unless there is a command.

    ``arguments``: those before ``--``, of which ``unknown`` are not the grader's; ``command``: those after it, or None
    without ``--``; ``exercise``: its name, as typed.
    """
    if command is None and unknown and not unknown[0].startswith('-'):
        cut = len(arguments) - arguments[::-1].index(unknown[0]) - 1
        raise UsageError('two dashes are missing between the exercise and the program; type:\n  '
                         + line(arguments[:cut], arguments[cut:]))
    if unknown:
        raise UsageError(f'there is no option {unknown[0]}; options of the program come after the two dashes:\n  '
                         + line([argument for argument in arguments if argument not in unknown],
                                [*(command or ['PROGRAM']), *unknown]))
    if not command:
        raise UsageError('the program is missing; type, for example:\n  '
                         + line(arguments, [f'{os.path.splitext(os.path.basename(exercise))[0]}.py']))


def check_program(arguments, command):
    """Raise UsageError unless the program of a command exists."""
    try:
        sandbox.runnable(command)
    except sandbox.MissingProgram as error:
        full = [f'/FULL/PATH/{os.path.basename(part)}' if part == error.program else part for part in command]
        raise UsageError(f'{error}.{_near(error.program)} Name the file as seen from here, a full path, or a command '
                         f'such as rosrun:\n  {line(arguments, full)}') from None
    except sandbox.CommandError:
        pass  # it exists, but does not run, which is the student's mistake


def line(before, after):
    return f'./run grade {shlex.join(before)} -- {shlex.join(after)}'


def _near(path):
    """Return a sentence about a file of nearly the same name, or ''."""
    folder, name = os.path.split(path)
    there = os.listdir(folder or '.') if os.path.isdir(folder or '.') else []
    close = difflib.get_close_matches(name, there, 1)
    return f' Did you mean {shlex.quote(os.path.join(folder, close[0]))}?' if close else ''


def check_student(chosen, student):
    """Raise UsageError if an exercise has values for each student, and nobody says whose."""
    if chosen.varies and not (student or '').strip():
        raise UsageError(f'the values of {chosen.name} differ from student to student: add --student NAME, as on the '
                         'sheet')
