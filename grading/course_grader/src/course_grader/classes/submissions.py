"""Finds the submissions of a class: which file is which student's program for which exercise. Without ROS.

The folder of a class contains one folder per student, and somewhere in it a file with the name of each exercise::

    FOLDER/anna/stop_at_x.py                a Python program, whatever its mode
    FOLDER/anna/src/topic_demo/scripts/publish_circle.py        or deeper, in a package or a repository
    FOLDER/ben/black_path.launch            a launch file, started by roslaunch
    FOLDER/ben/square_by_teleport           any other executable (also with an ending: square_by_teleport.bash)
    FOLDER/ben/set_pen_and_goto_pose.cmd    one line with a command; files that it names lie beside it
    FOLDER/exam.yaml                        an exercise file of the teacher's own

Names are matched ignoring case; '-' and '_' are the same. For a single exercise the folder may contain the programs
themselves, each with the name of its student.
"""
import os
import re
import shlex
from typing import Dict, Iterator, List, NamedTuple, Sequence, Tuple

from course_grader.isolation import sandbox, student_files

COMMAND = '.cmd'
STARTERS = '.launch', COMMAND  # they start other programs; the last has priority
TYPES = ('.py', *STARTERS)  # programs of any file mode
EXERCISE_TYPES = ('.yaml', '.yml')
VERSION = re.compile(r'[ _]*(\(\d+\)|v?\d+)$')  # at the end of the name of an attempt
MAX_LISTED = 8  # names in an error


class SubmissionsError(ValueError):
    """A folder contains nothing to grade; the text says what was expected and what was found."""


class Submission(NamedTuple):
    """A student's program for an exercise; ``trouble``: why there is no command to start."""

    student: str
    exercise: str
    command: Tuple[str, ...]
    folder: str
    trouble: str = ''
    packages: str = ''  # folder with the student's packages
    program: str = ''  # the file that has the exercise's name
    attempt: str = ''  # which of several attempts it is


def exercises_in(folder: str) -> Dict[str, str]:
    """Return {name: path} of the exercise files in a folder."""
    return {os.path.splitext(name)[0]: os.path.join(folder, name) for name in sorted(os.listdir(folder))
            if os.path.splitext(name)[1] in EXERCISE_TYPES}


def find(folder: str, names: Sequence[str], best: bool = False) -> Tuple[List[str], List[Submission], List[str]]:
    """Return (students, [Submission], programs left out) of a class for the exercises with these names.

    Programs with the name of no exercise are left out, such as ``stop_at_x (1).py``. With ``best`` that is an attempt,
    and so is each program of the same name in another folder of the student.
    """
    students = {_readable(name): name for name in _listed(folder) if os.path.isdir(os.path.join(folder, name))}
    found: List[Submission] = []
    others: List[str] = []
    keys = {_key(name): name for name in names}
    for student, name in students.items():
        own = os.path.abspath(os.path.join(folder, name))
        fitting: Dict[str, List[str]] = {}
        for path in _programs(os.path.join(folder, name)):
            key = _key(path) if _key(path) in keys or not best else VERSION.sub('', _key(path))
            fitting.setdefault(keys.get(key, ''), []).append(path)
        others += [os.path.relpath(path, folder) for path in fitting.pop('', [])]
        for exercise in names:
            found += [submission._replace(packages=own)
                      for submission in _of(student, exercise, fitting.get(exercise, []), own, best)]
    if not found:
        there = others or [name for name in _listed(folder) if name not in students.values()]
        raise SubmissionsError(
            f'{folder} contains no submissions. It needs one folder per student, with files that have the name of an '
            f'exercise ({", ".join(sorted(names))}), such as {os.path.join(folder, "anna", min(names) + ".py")}. '
            + (f'It contains {_some(there)}. ' if there else 'It is empty. ')
            + 'If it contains programs for one exercise, add --exercise NAME.')
    return list(students), found, others


def find_flat(folder: str, exercise: str) -> Tuple[List[str], List[Submission], List[str]]:
    """Return the same for a folder that contains the students' programs themselves."""
    paths = [os.path.join(folder, name) for name in _listed(folder)]
    by_student: Dict[str, List[str]] = {}
    for path in paths:
        if os.path.isfile(path) and _is_program(path):
            by_student.setdefault(_readable(os.path.splitext(os.path.basename(path))[0]), []).append(path)
    if not by_student:
        there = [os.path.basename(path) for path in paths]
        raise SubmissionsError(f'{folder} contains no program (a .py, .launch or .cmd file or an executable): '
                               + (f'it contains {_some(there)}' if there else 'it is empty'))
    found = [_choose(student, exercise, paths) for student, paths in sorted(by_student.items())]
    return sorted(by_student), found, []


def _of(student: str, exercise: str, paths: List[str], own: str, best: bool) -> List[Submission]:
    """Return the submissions of a student for an exercise; ``own``: the student's folder, ``best``: see find()."""
    groups: Dict[Tuple[str, str], List[str]] = {}
    for path in paths:
        groups.setdefault((os.path.dirname(path), _key(path)) if best else ('', ''), []).append(path)
    chosen = [_choose(student, exercise, group) for _, group in sorted(groups.items())]
    if len(chosen) < 2:
        return chosen
    return [one._replace(attempt=os.path.relpath(one.program, own).replace(os.sep, '+')) for one in chosen]


def _choose(student: str, exercise: str, paths: List[str]) -> Submission:
    """Return the Submission of the matching files: of the one that starts the others, or of the only one."""
    for kind in STARTERS:
        paths = [path for path in paths if path.endswith(kind)] or paths
    program = os.path.abspath(paths[0])
    folder = os.path.dirname(program)
    if len(paths) > 1:
        names = ', '.join(sorted(os.path.relpath(path, os.path.commonpath(list(map(os.path.dirname, paths))))
                                 for path in paths))
        return Submission(student, exercise, (), folder,
                          f'there are {len(paths)} programs for one exercise ({names}): keep one, or let the best '
                          'one count with --best', program=program)
    try:
        return Submission(student, exercise, _command(program, folder), folder, program=program)
    except (OSError, ValueError) as error:
        return Submission(student, exercise, (), folder, f'{paths[0]}: {error}', program=program)


def _command(path: str, folder: str) -> Tuple[str, ...]:
    if path.endswith('.launch'):
        return 'roslaunch', path
    if not path.endswith(COMMAND):
        return (path,)
    lines = [line.strip() for line in student_files.whole(path).decode().splitlines()
             if line.strip() and not line.startswith('#')]
    if len(lines) != 1:
        raise ValueError(f'it contains {len(lines)} command lines; it must contain one')
    sandbox.check_command(lines)
    program, *arguments = shlex.split(lines[0])
    beside = os.path.join(folder, program)
    return (beside if os.path.isfile(beside) else program, *sandbox.from_here(program, arguments, folder))


def _programs(folder: str) -> Iterator[str]:
    for parent, folders, names in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith(('.', '__')))
        yield from (os.path.join(parent, name) for name in sorted(names)
                    if not name.startswith('.') and _is_program(os.path.join(parent, name)))


def _is_program(path: str) -> bool:
    return path.endswith(TYPES) or os.access(path, os.X_OK)


def _key(path: str) -> str:
    return os.path.splitext(os.path.basename(path))[0].lower().replace('-', '_')


def _listed(folder: str) -> List[str]:
    return sorted(name for name in os.listdir(folder) if not name.startswith(('.', '__')))


def _readable(name: str) -> str:
    """Return a name with undecodable bytes as escape sequences, so that results have readable names."""
    return os.fsencode(name).decode('utf-8', 'backslashreplace')


def _some(names: Sequence[str]) -> str:
    return ', '.join(names[:MAX_LISTED]) + (f' and {len(names) - MAX_LISTED} more' if len(names) > MAX_LISTED else '')
