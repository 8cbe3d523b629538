"""Finds the submissions of a class: which file is which student's program for which exercise. Without ROS.

The folder of a class contains one folder per student, and somewhere in it a file with the name of each exercise::

    FOLDER/anna/stop_at_x.py                a Python program, whatever its mode
    FOLDER/anna/src/topic_demo/scripts/publish_circle.py        or deeper, in a package or a repository
    FOLDER/ben/black_path.launch            a launch file, started by roslaunch
    FOLDER/ben/square_by_teleport           any other executable or script (also with an ending, such as .bash)
    FOLDER/ben/set_pen_and_goto_pose.cmd    one line with a command; files that it names lie beside it
    FOLDER/ben/hand_in_map.yaml             a map, where an exercise asks for one; its image lies beside it
    FOLDER/exam.yaml                        an exercise file of the teacher's own

Names are matched ignoring case; '-' and '_' are the same. For a single exercise the folder may contain the programs
themselves, each with the name of its student. What is not graded is a LeftOut, with the reason.
"""
import difflib
import os
import re
import shlex
from typing import Callable, Dict, Iterator, List, NamedTuple, Optional, Sequence, Tuple

from course_grader.isolation import sandbox, student_files

STARTERS = '.launch', sandbox.COMMAND  # they start other programs; the last has priority
TYPES = ('.py', *STARTERS)  # programs of any file mode
EXERCISE_TYPES = ('.yaml', '.yml')
IMAGE = '.pgm'  # of a map
ARCHIVES = ('.zip', '.tar', '.tgz', '.gz', '.xz', '.bz2', '.7z', '.rar')
OF_A_PACKAGE = '__init__.py', 'setup.py'  # programs for no exercise
COMPILED = b'\x7fELF'
NOBODYS = 'it lies in the folder of no student'
MAX_PATH = 40  # characters of the path of a folder in many others
MAX_LEFT_OUT = 20  # files of a student that are listed one by one
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
    trouble: Optional[str] = None
    packages: str = ''  # folder with the student's packages
    program: str = ''  # the file that has the exercise's name
    attempt: str = ''  # which of several attempts it is
    handed_in: str = ''  # when, in ISO 8601, or LATE of platforms.py; '' if unknown


class LeftOut(NamedTuple):
    """What was handed in and is not graded: the student ('': nobody's), the path in the student's folder, and why."""

    student: str
    name: str
    reason: str

    def text(self) -> str:
        return f'{"/".join(filter(None, (self.student, self.name)))}: {self.reason}'


def exercises_in(folder: str) -> Dict[str, str]:
    """Return {name: path} of the exercise files in a folder."""
    return {os.path.splitext(name)[0]: os.path.join(folder, name) for name in sorted(os.listdir(folder))
            if os.path.splitext(name)[1] in EXERCISE_TYPES}


def find(folder: str, names: Sequence[str], best: bool = False, only: str = '',
         of_map: Callable[[str], bool] = lambda exercise: False) -> Tuple[List[str], List[Submission], List[LeftOut]]:
    """Return (students, [Submission], [LeftOut]) of a class for the exercises with these names.

    Programs with the name of no exercise are left out, such as ``stop_at_x (1).py``. With ``best`` that is an attempt,
    and so is each program of the same name in another folder of the student. ``only``: the single exercise, for which
    the only program of a student counts, whatever its name. ``of_map(exercise)``: whether a map file is handed in.
    """
    students = {_readable(name): name for name in _listed(folder) if os.path.isdir(os.path.join(folder, name))}
    found: List[Submission] = []
    left_out = [LeftOut('', _readable(name), NOBODYS) for name in _listed(folder)
                if name not in students.values() and not name.endswith(EXERCISE_TYPES)]
    keys = {_key(name): name for name in names}
    for student, name in students.items():
        own = os.path.abspath(os.path.join(folder, name))
        fitting: Dict[str, List[str]] = {}
        others: List[str] = []
        deep: List[str] = []
        for path in _files(own, deep.append):
            key = _key(path) if _key(path) in keys or not best else VERSION.sub('', _key(path))
            if key in keys and _fits(path, keys[key], of_map):
                fitting.setdefault(keys[key], []).append(path)
            else:
                others.append(path)
        programs = [path for path in others if only and _fits(path, only, of_map)]
        if not fitting and len(programs) == 1:
            fitting[only] = programs
            others.remove(programs[0])
        for exercise in names:
            found += [submission._replace(packages=own)
                      for submission in _of(student, exercise, fitting.get(exercise, []), own, best)]
        left_out += _left_out(student, own, others, deep, keys, bool(fitting))
    if not found:
        there = [os.path.join(one.student, one.name) for one in left_out if one.name]
        raise SubmissionsError(
            f'{folder} contains no submissions. It needs one folder per student, with files that have the name of an '
            f'exercise ({", ".join(sorted(names))}), such as {os.path.join(folder, "anna", min(names) + ".py")}. '
            + (f'It contains {_some(there)}. ' if there else 'It is empty. ')
            + 'If it contains programs for one exercise, add --exercise NAME.')
    return list(students), found, left_out


def _left_out(student: str, own: str, paths: Sequence[str], deep: Sequence[str], keys: Dict[str, str], graded: bool
              ) -> List[LeftOut]:
    """Return the files of a student that are not graded, without those that a program may need.

    ``deep``: folders that are too deep; ``graded``: whether there is a program that is.
    """
    reasons = {path: _why_left_out(path, keys) or (None if graded else 'it is not a program') for path in paths}
    found = [LeftOut(student, _readable(os.path.relpath(path, own)), reason)
             for path, reason in reasons.items() if reason]
    found += [LeftOut(student, _readable(os.path.relpath(path, own))[:MAX_PATH] + '...', 'it lies in more than '
                      f'{student_files.MAX_DEPTH} folders') for path in deep]
    if not paths and not deep and not graded:
        found.append(LeftOut(student, '', 'the folder is empty'))
    more = len(found) - MAX_LEFT_OUT
    return found if more <= 0 else [*found[:MAX_LEFT_OUT], LeftOut(student, '', f'{more} more files are not graded')]


def _why_left_out(path: str, keys: Dict[str, str]) -> Optional[str]:
    """Return why a file is not graded, None if it is not meant to be a program."""
    key = _key(os.path.basename(path).partition('.')[0])
    if path.lower().endswith(ARCHIVES):
        return 'it is an archive: unpack it'
    if os.path.basename(path) in OF_A_PACKAGE or path.endswith(IMAGE):
        return None
    if _is_program(path) and _key(path) in keys:
        return 'the exercise asks for another kind of file'
    if _is_program(path):
        meant = VERSION.sub('', key)
        close = [meant] if meant in keys else difflib.get_close_matches(key, keys, 1)
        return 'no exercise has this name' + (f': did you mean {keys[close[0]]}?' if close else '')
    if key not in keys:
        return None
    if not os.path.isfile(path):
        return 'it is not a file'
    if student_files.read(path, len(COMPILED)) == COMPILED:
        return f'it is not executable: type chmod +x {shlex.quote(path)}'
    return 'it is not a program: the name of a Python program ends in .py'


def has_programs(folder: str) -> bool:
    """Return whether a folder contains programs itself, or no folders."""
    paths = [os.path.join(folder, name) for name in _listed(folder)]
    return any(map(_is_program, filter(os.path.isfile, paths))) or not any(map(os.path.isdir, paths))


def find_flat(folder: str, exercise: str, of_map: Callable[[str], bool] = lambda exercise: False
              ) -> Tuple[List[str], List[Submission], List[LeftOut]]:
    """Return what find() does for a folder that contains the students' programs themselves."""
    paths = [os.path.join(folder, name) for name in _listed(folder)]
    by_student: Dict[str, List[str]] = {}
    left_out: List[LeftOut] = []
    for path in paths:
        name = _readable(os.path.basename(path))
        if os.path.isfile(path) and _fits(path, exercise, of_map):
            by_student.setdefault(os.path.splitext(name)[0], []).append(path)
        elif not path.endswith((*EXERCISE_TYPES, IMAGE)):
            left_out.append(LeftOut('', name, _why_left_out(path, {}) or 'it is not a program'))
    if not by_student:
        there = [os.path.basename(path) for path in paths]
        raise SubmissionsError(f'{folder} contains no program (a .py, .launch or .cmd file or an executable): '
                               + (f'it contains {_some(there)}' if there else 'it is empty'))
    found = [_choose(student, exercise, paths) for student, paths in sorted(by_student.items())]
    return sorted(by_student), found, left_out


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
        return Submission(student, exercise, _command(program), folder, program=program)
    except (OSError, ValueError) as error:
        return Submission(student, exercise, (), folder, f'{paths[0]}: {error}', program=program)


def _command(path: str) -> Tuple[str, ...]:
    if path.endswith('.launch'):
        return 'roslaunch', path
    if not path.endswith(sandbox.COMMAND):
        return (path,)
    return tuple(sandbox.command_in(path))


def _files(folder: str, too_deep: Callable[[str], object]) -> Iterator[str]:
    """Yield the files below a folder, without hidden ones; see student_files.walk()."""
    for parent, folders, names in student_files.walk(folder, too_deep):
        folders[:] = [name for name in folders if not name.startswith(('.', '__'))]
        yield from (os.path.join(parent, name) for name in names if not name.startswith('.'))


def _is_program(path: str) -> bool:
    """Return whether a file can be started, whatever its mode; only what is compiled has to be executable."""
    return path.endswith(TYPES) or os.path.isfile(path) and (
        os.access(path, os.X_OK) or bool(sandbox.interpreter_of(path)))


def _fits(path: str, exercise: str, of_map: Callable[[str], bool]) -> bool:
    """Return whether a file can be a submission for an exercise."""
    if path.endswith(EXERCISE_TYPES):
        return of_map(exercise)
    return _is_program(path) and not of_map(exercise)


def _key(path: str) -> str:
    return os.path.splitext(os.path.basename(path))[0].lower().replace('-', '_')


def _listed(folder: str) -> List[str]:
    return sorted(name for name in os.listdir(folder) if not name.startswith(('.', '__')))


def _readable(name: str) -> str:
    """Return a name with undecodable bytes as escape sequences, so that results have readable names."""
    return os.fsencode(name).decode('utf-8', 'backslashreplace')


def _some(names: Sequence[str]) -> str:
    return ', '.join(names[:MAX_LISTED]) + (f' and {len(names) - MAX_LISTED} more' if len(names) > MAX_LISTED else '')
