"""Runs a student's program in its own folders, with limited output, and ends everything that it started.

A program may start others, detach them, ignore signals and print forever: ``close`` ends all that have the environment
variable MARK or descends from here, until there is none left (see process_support). Should the grader itself be killed,
its guardian ends what has MARK.

Threading contract: a thread reads the output; ``lines`` only grows; copy it before iterating over it.
"""
import os
import re
import shlex
import shutil
import subprocess
import sys
import threading
import uuid
from typing import Any, Callable, Dict, List, Mapping, Optional, Protocol, Sequence, Set, Tuple

import psutil

from course_grader.rules.observation import OutputLine
from kinematic_core.timing.idle_threads import Gone, ProcessThreads
from kinematic_core.timing.stall_free_timer import ActiveTimer
from process_support import processes

MARK = 'TURTLE_ROBOTONT_GRADING'
FIRST_ON_PATH = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'student_path')  # of Python's modules
SHUT_DOWN = 'rospy.exceptions.ROSInterruptException: '  # the end of a loop after rospy.signal_shutdown
POLLING, SHORTEST = 0.1, 0.02  # share of the time that who polls runs at most; of at least so long [s]
FOLDERS = {'ROS_HOME': 'ros_home', 'ROS_LOG_DIR': 'log', 'TMPDIR': 'tmp', 'PWD': 'work'}  # variable: folder
CHUNK = 65536  # [bytes] read at once
MOST_LINES, LONGEST_LINE = 20_000, 2_000  # of the output that is kept; all of it is read
END_STAGES = processes.KILL  # what a program says or does when it is asked to end does not count
ANSI = re.compile(r'\x1b\[[0-9;]*[A-Za-z]')
ROSCONSOLE = re.compile(r'^\[ ?[A-Z]+\] \[[^\]]*\](?: \[[^\]]*\])?: ')  # what rospy puts before a logged text


class Started(Protocol):
    """What ``poll()`` returns the exit code of, or None while it runs; a Popen, for example."""

    pid: int

    def poll(self) -> Optional[int]:
        """Return the exit code, or None."""


class CommandError(ValueError):
    """A command cannot be run at all; the text says why and what to do."""


class MissingProgram(CommandError):
    """There is no such program."""


class Sandbox:
    """Folders, environment and processes of one grading; use it in a with statement."""

    def __init__(self, folder: str, environment: Mapping[str, str], mark: str = '') -> None:
        """``folder`` becomes home of everything that is written.

        ``environment``: of all that is started; ``mark``: the value of MARK in it, by default a new one.
        """
        self.folder = str(folder)
        self._mark = mark or uuid.uuid4().hex
        folders = {name: os.path.join(self.folder, subfolder) for name, subfolder in FOLDERS.items()}
        for path in folders.values():
            os.makedirs(path, exist_ok=True)
        self.environment = {**environment, **folders, MARK: self._mark, 'PYTHONUNBUFFERED': '1',
                            'PYTHONDONTWRITEBYTECODE': '1'}
        self._started: List[Started] = []
        self._guardian = psutil.Process()  # until there is one
        self._guardian, self._dismiss_guardian = processes.guard(self._end_all)
        processes.adopt_orphans()

    def start(self, command: Sequence[str], log: Optional[str] = None,
              environment: Optional[Mapping[str, str]] = None) -> 'subprocess.Popen[bytes]':
        """Start a command in a session of its own; return its Popen. ``log``: a file for its output, else a pipe.

        ``environment``: variables besides the sandbox's own.
        """
        output: Any = open(os.path.join(self.folder, log), 'wb') if log else subprocess.PIPE
        try:
            process = subprocess.Popen(command, cwd=self.environment['PWD'],
                                       env={**self.environment, **(environment or {})},
                                       stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
                                       start_new_session=True)
            self._started.append(process)
            return process
        finally:
            if log:
                output.close()

    def keep(self, process: Started) -> None:
        """Take in a child that was started elsewhere: its exit code is left to ``poll()``."""
        self._started.append(process)

    def close(self) -> None:
        """End everything at once, also what tries to remain."""
        self._end_all()
        self._dismiss_guardian()

    def _end_all(self) -> None:
        processes.end(self._alive, END_STAGES)
        for process in self._started:
            process.poll()
        remove_folders(self.folder)

    def _alive(self) -> Set[psutil.Process]:
        """Return the processes to end: those with the mark, and all that descend from this one."""
        kept = {process.pid for process in (*self._started, self._guardian)}
        return processes.related(f'{MARK}={self._mark}', psutil.Process(), kept) - {self._guardian}

    def __enter__(self) -> 'Sandbox':
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def remove_folders(folder: str) -> None:
    """Remove what a Sandbox has made in its folder."""
    for name in FOLDERS.values():
        shutil.rmtree(os.path.join(folder, name), ignore_errors=True)


class Student:
    """The student's program with its output: ``lines`` (OutputLine), ``dropped`` (lines that were too many)."""

    def __init__(self, sandbox: Sandbox, command: Sequence[str], now: Callable[[], float]) -> None:
        """``now()`` returns the simulated time [s] to book a line with."""
        self.lines: List[OutputLine] = []
        self.dropped, self._now = 0, now
        path = os.pathsep.join(filter(None, (FIRST_ON_PATH, sandbox.environment.get('PYTHONPATH'))))
        try:
            self.process = sandbox.start(command, environment={'PYTHONPATH': path})
        except OSError as error:
            raise CommandError(f'{shlex.join(command)} cannot be started: {error.strerror}') from None
        self._reader = threading.Thread(target=self._read, name='output', daemon=True)
        self._reader.start()

    def _read(self) -> None:
        output = self.process.stdout
        assert output is not None  # a pipe, without a log
        rest = b''
        for read in iter(lambda: os.read(output.fileno(), CHUNK), b''):
            *lines, rest = re.split(rb'[\r\n]', rest + read)
            for raw in lines:
                self._take(raw)
            while len(rest) > LONGEST_LINE:  # of a line that never ends
                self._take(rest[:LONGEST_LINE])
                rest = rest[LONGEST_LINE:]
        self._take(rest)

    def _take(self, raw: bytes) -> None:
        """Keep a line; one that ends with a carriage return alone is overwritten in a terminal, but it was printed."""
        for start in range(0, len(raw), LONGEST_LINE):
            if len(self.lines) >= MOST_LINES:
                self.dropped += 1
                continue
            text = ANSI.sub('', raw[start:start + LONGEST_LINE].decode('utf-8', 'replace'))
            if text:
                self.lines.append(OutputLine(self._now(), ROSCONSOLE.sub('', text)))

    def exit_code(self) -> Optional[int]:
        """Return its exit code, or None while it runs."""
        return self.process.poll()

    def runs(self) -> Optional[Dict[Tuple[int, str], int]]:
        """Return {(process, thread): how long it has run [ns]} of it and what it has started; None while one runs."""
        looked: Dict[Tuple[int, str], int] = {}
        for process in processes.descendant_ids(self.process.pid) | {self.process.pid}:
            threads = ProcessThreads(process)
            try:
                runs = threads.runs()
            except Gone:
                continue
            finally:
                threads.close()
            if runs is None:
                return None
            looked.update({(process, thread): ran for thread, ran in runs.items()})
        return looked

    def trouble(self) -> str:
        """Return how it failed, '' while it runs and after success.

        rospy.signal_shutdown in a callback ends a loop in the main thread with an exception, which is not a failure.
        """
        code = self.exit_code()
        if not code or code == 1 and self.said_last().startswith(SHUT_DOWN):
            return ''
        said = self.said_last()
        hint = '; input() does not work here: put all values into the program' if 'EOFError' in said else ''
        return f'the program ended with exit code {code}: {said}{hint}'

    def drain(self, timeout: float = 1.0) -> None:
        """Wait until the output of a program that has ended is read, at most ``timeout`` [s]."""
        self._reader.join(timeout)

    def said_last(self) -> str:
        """Return what explains its end: the last line of a traceback and where, or the last line."""
        texts = [line.text for line in list(self.lines)]
        last = next((text for text in reversed(texts) if text.strip()), 'it printed nothing')
        positions = [text.strip() for text in texts if re.match(r'\s+File ".*", line \d+', text)]
        return last + (f' ({positions[-1]})' if positions and 'Traceback' in ' '.join(texts) else '')


class ProgramIdleTimer:
    """Tells for how long a Student, with all that it has started, has been idle. To be looked at often."""

    def __init__(self, student: Student) -> None:
        self._student, self._idle = student, ActiveTimer()
        self._looked: Optional[Dict[Tuple[int, str], int]] = None

    def look(self) -> float:
        """Return for how long [s] nothing of it has run, or just to poll."""
        looked, before, past = self._student.runs(), self._looked, self._idle.waited
        self._looked = looked
        if looked is None or before is None:
            self._idle = ActiveTimer()
        else:
            ran = sum(total - before.get(thread, 0) for thread, total in looked.items())  # [ns]
            if ran > POLLING * 1e9 * max(self._idle.look() - past, SHORTEST):
                self._idle = ActiveTimer()
        return self._idle.look()


def runnable(command: Sequence[str]) -> Tuple[List[str], List[str]]:
    """Return (command to start, remarks) of what a student typed; raise CommandError when it cannot be run.

    A Python file runs with this Python, whatever its mode, first line or line ends; the remarks say why rosrun could
    not run it.
    """
    if not command:
        raise MissingProgram('the command is missing; type: ./run grade EXERCISE -- COMMAND')
    program, *arguments = command
    if program.endswith('.launch') and os.path.isfile(program):
        program, arguments = 'roslaunch', list(command)
    if not os.path.exists(program):
        return _by_name(program, arguments)
    program = os.path.abspath(program)
    if os.path.isdir(program):
        raise CommandError(f'{program} is a folder; name the program in it')
    if not os.access(program, os.R_OK):
        raise CommandError(f'{program} cannot be read; type: chmod +r {shlex.quote(program)}')
    with open(program, 'rb') as file:
        source = file.read()
    if not program.endswith('.py') and not _is_python(source):
        if not os.access(program, os.X_OK):
            raise CommandError(f'{program} is not executable; type: chmod +x {shlex.quote(program)}')
        if source.startswith(b'#!') and b'\r' in source.split(b'\n', 1)[0]:
            raise CommandError(f'{program}: the first line ends with CR LF (Windows), so Linux does not find the '
                               f"interpreter; type: sed -i 's/\\r$//' {shlex.quote(program)}")
        return [program, *arguments], []
    return [sys.executable, program, *arguments], _remarks(program, source)


def _by_name(program: str, arguments: List[str]) -> Tuple[List[str], List[str]]:
    """As runnable(), of a program that is no file here."""
    if program in ('python', 'python3') and arguments and os.path.isfile(arguments[0]):
        return runnable(arguments)
    if program in ('python', 'python3') and arguments and arguments[0].endswith('.py'):
        program = arguments[0]
    if '/' not in program and not program.endswith('.py') and shutil.which(program):
        on_screen = ['--screen'] if program == 'roslaunch' else []  # because log output counts as printed output
        return [program, *on_screen, *from_here(program, arguments)], []
    raise MissingProgram(f'{program} does not exist (current folder: {os.getcwd()})')


def package_of(command: Sequence[str]) -> Optional[str]:
    """Return the folder of the package that a file of a command lies in, or None."""
    for part in command:
        folder = os.path.dirname(os.path.abspath(part)) if os.path.isfile(part) else os.sep
        while folder != os.path.dirname(folder):
            if os.path.isfile(os.path.join(folder, 'package.xml')):
                return folder
            folder = os.path.dirname(folder)
    return None


def from_here(program: str, arguments: Sequence[str], folder: str = '.') -> List[str]:
    """Return the arguments with full paths of those that are files in ``folder``, as they are used in another one.

    rosrun's are names below a package; roslaunch's, too, unless the first one is a file.
    """
    def there(argument: str) -> str:
        path = os.path.join(folder, argument)
        return os.path.abspath(path) if os.path.isfile(path) else argument
    if program == 'rosrun' or (program == 'roslaunch' and arguments and there(arguments[0]) == arguments[0]):
        return list(arguments)
    return [there(argument) for argument in arguments]


def _is_python(source: bytes) -> bool:
    return source.startswith(b'#!') and b'python' in source.split(b'\n', 1)[0]


def _remarks(program: str, source: bytes) -> List[str]:
    """Return why rosrun could not run a Python file; raise CommandError if it is not Python."""
    try:
        compile(source, program, 'exec')
    except (SyntaxError, ValueError) as error:
        line = getattr(error, 'lineno', None)
        what = getattr(error, 'msg', None) or error
        raise CommandError(f'{os.path.basename(program)}{f", line {line}" if line else ""}: '
                           f'{type(error).__name__}: {what}') from None
    remarks = []
    if not source.startswith(b'#!'):
        remarks.append('the first line should be #!/usr/bin/env python3; otherwise rosrun cannot start the file')
    if b'\r\n' in source:
        remarks.append('the lines end with CR LF (Windows), and rosrun cannot start such a file; type: '
                       "sed -i 's/\\r$//' FILE")
    if not os.access(program, os.X_OK):
        remarks.append('the file is not executable, so rosrun cannot start it; type: chmod +x FILE')
    return remarks
