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

from browser_servers.core import web
from course_page.starter import last_lines
from plain_support.processes import BackgroundProcess, end_with_parent

GRADE = ('rosrun', 'course_grader', 'grade')
SOURCED = 'TURTLE_ROBOTONT_SOURCED'  # set by ./run view: the ROS_PACKAGE_PATH of the terminal
KINDS = ('', '.bash', '.launch', '.py', '.sh')  # endings of programs
NO_PROGRAMS = ('__init__.py', 'setup.py')
SKIPPED = ('build', 'devel', 'install', 'logs', 'node_modules', 'output', '__pycache__')  # folders without programs
REPOSITORY = os.path.realpath(__file__).partition('/packages/web/course_page/')[0]
SYSTEM = ('/bin', '/lib', '/opt/ros', '/sbin', '/usr')
NOT_THEIRS = tuple(map(pathlib.Path, (REPOSITORY, *SYSTEM)))
MAX_PROGRAMS, MAX_SEEN = 200, 5000  # the newest ones of so many files and folders
LARGEST_PROGRAM = 1 << 20  # [bytes]; ./run grade refuses larger ones, too
LIST_TIMEOUT = 60.0  # [s] in which the grader must list its exercises
STAGES = ((signal.SIGINT, 20.0), (signal.SIGKILL, 2.0))  # it ends all that it has started itself
TAIL = 65536  # [bytes] of the program's output that is shown


class Refused(ValueError):
    """A grading that cannot start; the text says why."""


def folders(home='.', environment=None):
    """Return the folders with the user's programs: ``home``, and the sourced workspaces.

    ROS and this repository are not among them.
    """
    environment = os.environ if environment is None else environment
    listed = f'{environment.get(SOURCED, "")}:{environment.get("ROS_PACKAGE_PATH", "")}'.split(':')
    found = [pathlib.Path(place).resolve() for place in (home, *filter(None, listed))]
    return [place for place in dict.fromkeys(found) if place.is_dir() and not _is_ours(place)]


def _is_ours(place):
    """Return whether a folder belongs to the system or to this repository."""
    return any(place == one or one in place.parents for one in NOT_THEIRS)


def programs(places):
    """Return the paths of the programs in folders, the newest first; folders near the top are searched first."""
    found, queue, seen, known = {}, list(places), 0, set()
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
                found.setdefault(str(real / entry.name), entry.stat().st_mtime)
    return sorted(found, key=lambda path: (-found[path], path))[:MAX_PROGRAMS]


def _is_program(entry):
    ending = os.path.splitext(entry.name)[1]
    if ending not in KINDS or entry.name in NO_PROGRAMS or not entry.is_file(follow_symlinks=False):
        return False
    status = entry.stat()
    return status.st_size <= LARGEST_PROGRAM and (ending in ('.launch', '.py') or bool(status.st_mode & stat.S_IXUSR))


class Grader:
    """The last grading that was started here, and what can be graded."""

    def __init__(self, home='.', command=GRADE):
        self._home, self._command, self._exercises = home, command, None
        self._folder = tempfile.TemporaryDirectory(prefix='turtle_robotont_grade_')
        self._numbers = itertools.count(1)
        self._number, self._asked, self._process, self._begun, self._ended = 0, ('', ''), None, 0.0, None
        self._stopping = False

    async def choices(self):
        """Return a dict of exercises and programs, for JSON; ``error`` says why there are no exercises."""
        run = asyncio.get_event_loop().run_in_executor
        error = ''
        if self._exercises is None:
            self._exercises, error = await run(None, self._list)
        places = await run(None, folders, self._home)
        found = await run(None, programs, places)
        return {'exercises': self._exercises or [], 'programs': found, 'folders': list(map(str, places)),
                'error': error}

    def _list(self):
        """Return (exercises, '') or (None, why there are none)."""
        try:
            done = subprocess.run([*self._command, '--list', 'json'], stdin=subprocess.DEVNULL, capture_output=True,
                                  text=True, timeout=LIST_TIMEOUT, check=False)
            return json.loads(done.stdout), ''
        except (OSError, subprocess.TimeoutExpired) as error:
            return None, str(error)
        except ValueError:
            return None, last_lines(done.stderr)

    async def start(self, exercise, program):
        """Grade a program; raise Refused, or OSError."""
        choices = await self.choices()
        if exercise not in [one['name'] for one in choices['exercises']]:
            raise Refused(f'there is no exercise {exercise!r:.80}; choose one of the list')
        if program not in choices['programs']:
            raise Refused(f'{program!r:.200} is not a program of the list; save it in one of these folders: '
                          f'{", ".join(choices["folders"])}')
        if self._runs():
            raise Refused(f'{os.path.basename(self._asked[1])} is being graded; one grading runs at a time')
        self._number, self._asked, self._ended = next(self._numbers), (exercise, program), None
        self._begun = time.monotonic()
        self._process = BackgroundProcess(
            [*self._command, exercise, f'--output={self._place()}', '--', program], f'{self._place()}.txt',
            cwd=self._home, preexec_fn=functools.partial(end_with_parent, signal.SIGINT, os.getpid()))

    async def stop(self):
        if self._runs() and not self._stopping:
            self._stopping = True
            try:
                await asyncio.get_event_loop().run_in_executor(None, self._process.stop, STAGES)
            finally:
                self._stopping = False

    def state(self):
        """Return a dict of the last grading, for JSON; ``state`` is none, running, stopping, graded or failed."""
        exercise, program = self._asked
        shown = {'number': self._number, 'exercise': exercise, 'program': program, 'state': 'none', 'seconds': 0.0}
        if self._process is None:
            return shown
        running = self._runs()
        if not running and self._ended is None:
            self._ended = time.monotonic()
        shown['seconds'] = round((self._ended or time.monotonic()) - self._begun, 1)
        if running:
            return {**shown, 'state': 'stopping' if self._stopping else 'running',
                    'said': last_lines(self._process.output(TAIL))}
        result = self._result()
        return {**shown, 'state': 'failed' if result is None else 'graded',
                'said': last_lines(self._process.output(TAIL)), 'result': result, 'output': self._read('output.txt'),
                'picture': os.path.exists(self.picture()), 'line': self._line(result)}

    def picture(self):
        """Return the path of the picture of the last grading, which not every exercise has."""
        return os.path.join(self._place(), 'path.png')

    def end(self):
        """End the grading; the loop has ended."""
        if self._process is not None:
            self._process.stop(STAGES)
        self._folder.cleanup()

    def _runs(self):
        return self._process is not None and self._process.runs()

    def _place(self):
        return os.path.join(self._folder.name, str(self._number))

    def _line(self, result):
        seed = f' --seed {result["seed"]}' if result else ''
        return f'./run grade {self._asked[0]}{seed} -- {shlex.quote(self._asked[1])}'

    def _result(self):
        try:
            return json.loads(self._read('result.json', None))
        except ValueError:
            return None

    def _read(self, name, most=TAIL):
        try:
            with open(os.path.join(self._place(), name), encoding='utf-8', errors='replace') as file:
                return file.read(most)
        except OSError:
            return ''


class Choices(web.Guarded):
    """GET: what can be graded, as JSON."""

    async def get(self):
        self.answer_json(json.dumps(await self.settings['grader'].choices()))


class Gradings(web.Guarded):
    """GET: the last grading, as JSON. POST ``{"exercise": ..., "program": ...}`` starts one, ``{}`` ends it."""

    def get(self):
        self.answer_json(json.dumps(self.settings['grader'].state()))

    async def post(self):
        """Start or end a grading; answer with the state, or with 400 and what is allowed."""
        grader = self.settings['grader']
        try:
            asked = json.loads(self.request.body)
            if asked == {}:
                await grader.stop()
            else:
                await grader.start(asked['exercise'], asked['program'])
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

    def get(self):
        try:
            with open(self.settings['grader'].picture(), 'rb') as file:
                picture = file.read()
        except OSError:
            self.refuse(404, 'the last grading has no picture')
            return
        self.set_header('Content-Type', 'image/png')
        self.set_header('Cache-Control', 'no-store')
        self.finish(picture)
