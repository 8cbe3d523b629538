"""Grading from the page: an exercise and a program of two lists, with nothing else from outside, one at a time.

The grader is the program of ``./run grade``: it has a master of its own, and isolates the program as in a terminal.

Threading contract: the loop's thread calls all methods; what takes long runs in threads of the loop's executor.
"""
import asyncio
import functools
import itertools
import json
import os
import pathlib
import shlex
import signal
import stat
import subprocess
import tempfile
import time
from typing import Any, Dict, Iterable, List, Mapping, Optional, Sequence, Set

from browser_servers.core import web
from course_page.reasons import last_lines
from plain_support import course
from plain_support.processes import BackgroundProcess, end_with_parent

GRADE = ('rosrun', 'course_grader', 'grade')
SOURCED = 'TURTLE_ROBOTONT_SOURCED'  # set by ./run view: the ROS_PACKAGE_PATH of the terminal
KINDS = ('', '.bash', '.launch', '.py', '.sh')  # endings of programs
NO_PROGRAMS = ('__init__.py', 'setup.py')
SKIPPED = ('build', 'devel', 'install', 'logs', 'node_modules', 'output', '__pycache__')  # folders without programs
SYSTEM = tuple(map(pathlib.Path, ('/bin', '/lib', '/opt/ros', '/sbin', '/usr')))
MAX_PROGRAMS, MAX_SEEN = 200, 5000  # the newest ones of so many files and folders
LARGEST_PROGRAM = 1 << 20  # [bytes]; ./run grade refuses larger ones, too
LIST_TIMEOUT = 60.0  # [s] in which the grader must list its exercises
STAGES = ((signal.SIGINT, 20.0), (signal.SIGKILL, 2.0))  # it ends all that it has started itself
TAIL = 65536  # [bytes] of the program's output that is shown


class Refused(ValueError):
    """A grading that cannot start; the text says why."""


class NoExercises(Exception):
    """The grader lists no exercises; the text says why."""


def folders(home: str = '.', environment: Optional[Mapping[str, str]] = None) -> List[pathlib.Path]:
    """Return the folders with the user's programs: ``home``, and the sourced workspaces.

    ROS and this repository are not among them.
    """
    environment = os.environ if environment is None else environment
    listed = f'{environment.get(SOURCED, "")}:{environment.get("ROS_PACKAGE_PATH", "")}'.split(':')
    paths = [pathlib.Path(path).resolve() for path in (home, *filter(None, listed))]
    return [path for path in dict.fromkeys(paths) if path.is_dir() and not _is_ours(path)]


def _is_ours(folder: pathlib.Path) -> bool:
    """Return whether a folder belongs to the system or to this repository."""
    return any(ours in (folder, *folder.parents) for ours in (course.repository(), *SYSTEM))


def programs(searched: Iterable[pathlib.Path]) -> List[str]:
    """Return the paths of the programs in folders, the newest first; folders near the top are searched first."""
    times: Dict[str, float] = {}
    known: Set[pathlib.Path] = set()
    queue, seen = list(searched), 0
    while queue and seen < MAX_SEEN:
        folder = queue.pop(0)
        real = folder.resolve()
        if real in known or _is_ours(real):
            continue
        known.add(real)
        try:
            entries = sorted(os.scandir(folder), key=lambda entry: entry.name)
        except OSError:
            continue
        seen += len(entries)
        for entry in entries:
            if entry.name.startswith('.') or entry.name in SKIPPED:
                continue
            if entry.is_dir():
                queue.append(pathlib.Path(entry.path))
            elif _is_program(entry):
                times.setdefault(str(real / entry.name), entry.stat().st_mtime)
    return sorted(times, key=lambda path: (-times[path], path))[:MAX_PROGRAMS]


def _is_program(entry: 'os.DirEntry[str]') -> bool:
    ending = os.path.splitext(entry.name)[1]
    if ending not in KINDS or entry.name in NO_PROGRAMS or not entry.is_file(follow_symlinks=False):
        return False
    status = entry.stat()
    return status.st_size <= LARGEST_PROGRAM and (ending in ('.launch', '.py') or bool(status.st_mode & stat.S_IXUSR))


class Grader:
    """The last grading that was started here, and what can be graded."""

    def __init__(self, home: str = '.', command: Sequence[str] = GRADE) -> None:
        self._home, self._command = home, command
        self._exercises: Optional[List[Dict[str, Any]]] = None
        self._folder = tempfile.TemporaryDirectory(prefix='turtle_robotont_grade_')
        self._numbers = itertools.count(1)
        self._number, self._exercise, self._program = 0, '', ''  # of the last grading
        self._process: Optional[BackgroundProcess] = None
        self._begun = 0.0
        self._ended: Optional[float] = None
        self._stopping = False

    async def choices(self) -> Dict[str, Any]:
        """Return a dict of exercises and programs, for JSON; ``error`` says why there are no exercises."""
        run = asyncio.get_event_loop().run_in_executor
        error = ''
        if self._exercises is None:
            try:
                self._exercises = await run(None, self._list)
            except NoExercises as absent:
                error = str(absent)
        searched = await run(None, folders, self._home)
        found = await run(None, programs, searched)
        return {'exercises': self._exercises or [], 'programs': found, 'folders': list(map(str, searched)),
                'error': error}

    def _list(self) -> List[Dict[str, Any]]:
        """Return the exercises that the grader has; raise NoExercises."""
        try:
            done = subprocess.run([*self._command, '--list', 'json'], stdin=subprocess.DEVNULL, capture_output=True,
                                  text=True, timeout=LIST_TIMEOUT, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise NoExercises(str(error)) from None
        try:
            exercises: List[Dict[str, Any]] = json.loads(done.stdout)
        except ValueError:
            raise NoExercises(last_lines(done.stderr)) from None
        return exercises

    async def start(self, exercise: object, program: object) -> None:
        """Grade a program; raise Refused, or OSError."""
        choices = await self.choices()
        if exercise not in [known['name'] for known in choices['exercises']]:
            raise Refused(f'there is no exercise {exercise!r:.80}; choose one of the list')
        if program not in choices['programs']:
            raise Refused(f'{program!r:.200} is not a program of the list; save it in one of these folders: '
                          f'{", ".join(choices["folders"])}')
        if self._runs():
            raise Refused(f'{os.path.basename(self._program)} is being graded; one grading runs at a time')
        self._number, self._exercise, self._program = next(self._numbers), str(exercise), str(program)
        self._begun, self._ended = time.monotonic(), None
        self._process = BackgroundProcess(
            [*self._command, self._exercise, f'--output={self._output_folder()}', '--', self._program],
            f'{self._output_folder()}.txt',
            cwd=self._home, preexec_fn=functools.partial(end_with_parent, signal.SIGINT, os.getpid()))

    async def stop(self) -> None:
        if self._process is not None and self._process.runs() and not self._stopping:
            self._stopping = True
            try:
                await asyncio.get_event_loop().run_in_executor(None, self._process.stop, STAGES)
            finally:
                self._stopping = False

    def state(self) -> Dict[str, Any]:
        """Return a dict of the last grading, for JSON; ``state`` is none, running, stopping, graded or failed."""
        shown = {'number': self._number, 'exercise': self._exercise, 'program': self._program, 'state': 'none',
                 'seconds': 0.0}
        if self._process is None:
            return shown
        running, log = self._process.runs(), last_lines(self._process.output(TAIL))
        if not running and self._ended is None:
            self._ended = time.monotonic()
        shown['seconds'] = round((self._ended or time.monotonic()) - self._begun, 1)
        if running:
            return {**shown, 'state': 'stopping' if self._stopping else 'running', 'log': log}
        result = self._result()
        return {**shown, 'state': 'failed' if result is None else 'graded', 'log': log, 'result': result,
                'output': self._read('output.txt', TAIL), 'picture': os.path.exists(self.picture()),
                'command': self._command_line(result)}

    def picture(self) -> str:
        """Return the path of the picture of the last grading, which not every exercise has."""
        return os.path.join(self._output_folder(), 'path.png')

    def end(self) -> None:
        """End the grading; the loop has ended."""
        if self._process is not None:
            self._process.stop(STAGES)
        self._folder.cleanup()

    def _runs(self) -> bool:
        return self._process is not None and self._process.runs()

    def _output_folder(self) -> str:
        return os.path.join(self._folder.name, str(self._number))

    def _command_line(self, result: Optional[Dict[str, Any]]) -> str:
        seed = f' --seed {result["seed"]}' if result else ''
        return f'./run grade {self._exercise}{seed} -- {shlex.quote(self._program)}'

    def _result(self) -> Optional[Dict[str, Any]]:
        try:
            result: Dict[str, Any] = json.loads(self._read('result.json'))
        except ValueError:
            return None
        return result

    def _read(self, name: str, limit: int = -1) -> str:
        try:
            with open(os.path.join(self._output_folder(), name), encoding='utf-8', errors='replace') as file:
                return file.read(limit)
        except OSError:
            return ''


class Choices(web.Guarded):
    """GET: what can be graded, as JSON."""

    async def get(self) -> None:
        self.answer_json(json.dumps(await self.settings['grader'].choices()))


class Gradings(web.Guarded):
    """GET: the last grading, as JSON. POST ``{"exercise": ..., "program": ...}`` starts one, ``{}`` ends it."""

    def get(self) -> None:
        self.answer_json(json.dumps(self.settings['grader'].state()))

    async def post(self) -> None:
        """Start or end a grading; answer with the state, or with 400 and what is allowed."""
        grader = self.settings['grader']
        try:
            request = json.loads(self.request.body)
            if request == {}:
                await grader.stop()
            else:
                await grader.start(request['exercise'], request['program'])
        except OSError as error:
            self.refuse(500, f'the grader cannot be started: {error.strerror or error}')
        except Refused as error:
            self.refuse(400, str(error))
        except (KeyError, TypeError, ValueError):
            self.refuse(400, 'the request must be {"exercise": NAME, "program": PATH} of the lists, or {} to end a '
                        'grading')
        else:
            self.get()


class Picture(web.Guarded):
    """GET: the picture of the last grading."""

    def get(self) -> None:
        try:
            with open(self.settings['grader'].picture(), 'rb') as file:
                picture = file.read()
        except OSError:
            self.refuse(404, 'the last grading has no picture')
            return
        self.set_header('Content-Type', 'image/png')
        self.set_header('Cache-Control', 'no-store')
        self.finish(picture)
