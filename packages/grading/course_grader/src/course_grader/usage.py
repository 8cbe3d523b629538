"""Finds wrong usage of ./run grade before anything starts; errors give the line to type."""
import difflib
import os
import shlex
from typing import Iterable, Mapping, Optional, Sequence

import rospkg

from course_grader.isolation import sandbox, sourced, view
from course_grader.isolation.sourced import Sourced
from course_grader.rules.exercise import Exercise, ExerciseError
from course_grader.rules.values import meant
from course_grader.supervision.supervisor import others_of
from plain_support import course


class UsageError(ValueError):
    """The command line is wrong; the text says what to type."""


def check(arguments: Sequence[str], unknown: Sequence[str], command: Optional[Sequence[str]], exercise: str) -> None:
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


def check_student(chosen: Exercise, student: Optional[str]) -> None:
    """Raise UsageError if an exercise has values for each student, and nobody says whose."""
    if chosen.varies and not (student or '').strip():
        raise UsageError(f'the values of {chosen.name} differ from student to student: add --student NAME, as on the '
                         'sheet')


def check_program(arguments: Sequence[str], command: Sequence[str]) -> None:
    """Raise UsageError unless the program of a command exists."""
    try:
        sandbox.runnable(command)
    except sandbox.MissingProgram as error:
        folder, name = os.path.split(error.program)
        there = os.listdir(folder or '.') if os.path.isdir(folder or '.') else []
        near = [f' Did you mean {shlex.quote(os.path.join(folder, close))}?'
                for close in difflib.get_close_matches(name, there, 1)]
        full = [f'/FULL/PATH/{name}' if part == error.program else part for part in command]
        raise UsageError(f'{error}.{"".join(near)} Name the file as seen from here, a full path, or a command such as '
                         f'rosrun:\n  {line(arguments, full)}') from None
    except sandbox.CommandError:
        pass  # it exists, but does not run, which is the student's mistake


def check_package(arguments: Sequence[str], command: Sequence[str]) -> None:
    """Raise UsageError if rosrun or roslaunch would not find the package of a command."""
    program, *words = command
    words = [word for word in words if not word.startswith('-')]
    if program not in ('rosrun', 'roslaunch') or not words or os.path.isfile(words[0]):
        return
    known = [*rospkg.RosPack().list(), *(name for name, _ in sourced_packages(os.environ).packages)]
    if words[0] not in known:
        raise UsageError(
            f'there is no package {words[0]} in the workspaces of this terminal{meant(words[0], known) or "."} Type '
            'this, with the folder of your workspace:\n'
            f'  source ~/ros_ws/devel/setup.bash\n  {line(arguments, command)}')


def check_folder(folder: str) -> None:
    """Raise UsageError if results would replace files that no grading has written."""
    others = others_of(folder)
    if others:
        raise UsageError(f'{folder} has {", ".join(others)}, which this would replace, and no results of a grading. '
                         'Choose another folder with --output')


def find(name: str, known: Mapping[str, str]) -> str:
    """Return the path of an exercise, given by its name in ``known``, {name: path}, or as a file."""
    if name in known:
        return known[name]
    if os.path.exists(name):
        return name
    raise ExerciseError(f'there is no exercise {name!r}; give the path of an exercise file, or one of '
                        f'{", ".join(known)}{meant(name, known)}')


def sourced_packages(environment: Mapping[str, str]) -> Sourced:
    """Return the Sourced packages of the terminal, without ROS and this repository."""
    entries = sourced.folders_in(environment, sourced.PACKAGE_PATH, 'ROS_PACKAGE_PATH')
    prefixes = sourced.folders_in(environment, sourced.PREFIX_PATH, 'CMAKE_PREFIX_PATH')
    others = [*view.SYSTEM, str(course.repository())]
    known = rospkg.RosPack(sourced.outside(entries, others))
    packages = [(name, known.get_path(name)) for name in sorted(known.list())]
    return Sourced(tuple((name, folder) for name, folder in packages if sourced.outside([folder], others)),
                   tuple(sourced.outside(prefixes, view.SYSTEM)))


def line(before: Iterable[str], after: Iterable[str]) -> str:
    """Return the command line of a grading."""
    return f'./run grade {shlex.join(before)} -- {shlex.join(after)}'
