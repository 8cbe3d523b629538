"""Runs a student's program in its own folders, isolated and limited, and ends everything that it started.

A program may start others, detach them, ignore signals and print forever: ``close`` ends all that are in its namespace
or belong to its user, and all that have the environment variable MARK or descend from here, until there is none left
(see plain_support). Should the grader itself be killed, its guardian does the same.

Threading contract: a thread reads the output; ``lines`` only grows; copy it before iterating over it.
"""
import contextlib
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import uuid
from typing import Any, Callable, Dict, List, Mapping, Optional, Protocol, Sequence, Set, Tuple

import psutil

from course_grader.isolation import confinement, levels, limits, student_files, view
from course_grader.isolation.confinement import NO_ISOLATION, Isolation
from course_grader.rules.observation import OutputLine
from kinematic_core.timing.idle_threads import Gone, ProcessThreads
from kinematic_core.timing.stall_free_timer import ActiveTimer
from plain_support import processes
from plain_support.doctor import findings, programs

MARK = 'TURTLE_ROBOTONT_GRADING'
SHUT_DOWN = 'rospy.exceptions.ROSInterruptException: '  # the end of a loop after rospy.signal_shutdown
POLLING, SHORTEST = 0.1, 0.02  # share of the time that who polls runs at most; of at least so long [s]
FOLDERS = {'ROS_HOME': 'ros_home', 'ROS_LOG_DIR': 'log', 'TMPDIR': 'tmp'}  # of the grader itself: variable: folder
PROGRAM = 'program'  # folder of the program, where it has no file system of its own
URGENT = -10  # nice value of the thread that looks at the limits
CHUNK = 65536  # [bytes] read at once
LONGEST_COMMAND = 100_000  # [bytes] with all its arguments; Linux takes 131,071 in one
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
    """There is no such program; ``program`` is the part of the command that names it."""

    def __init__(self, text: str, program: str = '') -> None:
        super().__init__(text)
        self.program = program


class IsolationError(RuntimeError):
    """The program could not be isolated, and was not started."""


class Sandbox:
    """Folders, environment and processes of one grading; use it in a with statement."""

    def __init__(self, folder: str, environment: Mapping[str, str], mark: str = '',
                 isolation: Isolation = NO_ISOLATION, hidden: Sequence[str] = ()) -> None:
        """``folder`` becomes home of everything that the grader writes.

        ``environment``: of all that is started; ``mark``: the value of MARK in it, by default a new one; ``hidden``:
        folders that the program does not see, even below its own. Raise OSError.
        """
        self.folder = str(folder)
        self._isolation, self._hidden = isolation, hidden
        self._mark = mark or uuid.uuid4().hex
        folders = {name: os.path.join(self.folder, subfolder) for name, subfolder in FOLDERS.items()}
        for path in folders.values():
            os.makedirs(path, exist_ok=True)
        self.environment = {**environment, **folders, MARK: self._mark, 'PYTHONUNBUFFERED': '1',
                            'PYTHONDONTWRITEBYTECODE': '1'}
        needs_user = os.geteuid() == 0 and isolation.users and isolation.level != levels.NONE
        self._user = confinement.User() if needs_user else None
        self._program = os.path.join(self.folder, PROGRAM)
        if isolation.level == levels.UID:  # where its user can go
            self._program = tempfile.mkdtemp(prefix='turtle_robotont_', dir=view.temporary())
            os.chmod(self._program, 0o711)
        self._started: List[Started] = []
        self._guardian = psutil.Process()  # until there is one
        self._guardian, self._dismiss_guardian = processes.guard(self._end_all)
        processes.adopt_orphans()

    def start(self, command: Sequence[str]) -> 'Program':
        """Start a command, isolated, in a session of its own. Raise OSError, or IsolationError."""
        isolation, inside = self._isolation, self._isolation.level == levels.NAMESPACE
        base, temporary = (confinement.HOME, confinement.TEMPORARY) if inside else (
            self._program, os.path.join(self._program, 'tmp'))
        surroundings = view.environment(self.environment, base, temporary)
        shown = view.shown(surroundings, isolation.own)
        if isolation.level != levels.NONE:
            _check_own(command, shown)
        user = self._user.number if self._user else None
        if not inside:
            try:
                command, surroundings = self._prepare(command, surroundings, shown, user)
            except OSError as error:
                raise IsolationError(f'the files of the program could not be prepared: {error}') from None
        receiver, sender = os.pipe()
        try:
            line = confinement.confined(isolation, command, surroundings, shown, user, sender, self._hidden)
            process = subprocess.Popen(line, cwd=os.sep if inside else surroundings['PWD'],
                                       env={**surroundings, MARK: self._mark}, stdin=subprocess.DEVNULL,
                                       stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
                                       pass_fds=[sender] if inside else ())
        finally:
            os.close(sender)
        self._started.append(process)
        return Program(process, receiver, inside, isolation.limits, self._program,
                       lambda: self._end_program(psutil.Process(process.pid)))

    def _prepare(self, command: Sequence[str], surroundings: Dict[str, str], shown: Sequence[Tuple[str, str]],
                 user: Optional[int]) -> Tuple[Sequence[str], Dict[str, str]]:
        """Make the folders of a program that sees all files; return command and environment, as ``user`` can use them.

        Raise OSError.
        """
        for path in view.folders(surroundings):
            os.makedirs(path, exist_ok=True)
        if user is not None:
            command, surroundings = view.staged(command, surroundings, shown, os.path.join(self._program, 'files'))
            for path in view.folders(surroundings):
                os.chown(path, user, user)
        return command, surroundings

    def _end_program(self, first: psutil.Process) -> None:
        """End all processes of a program at once, however many there are; ``first`` was started here."""
        if self._isolation.level == levels.NAMESPACE:
            first.kill()  # with it ends all that is inside
        elif self._user:
            confinement.end_user(self._user.number)
        else:
            processes.end(lambda: processes.related(f'{MARK}={self._mark}', first, self._kept()), processes.KILL)

    def keep(self, process: Started) -> None:
        """Take in a child that was started elsewhere: its exit code is left to ``poll()``."""
        self._started.append(process)

    def close(self) -> None:
        """End everything at once, also what tries to remain."""
        self._end_all()
        self._dismiss_guardian()

    def _end_all(self) -> None:
        if self._user and self._isolation.level == levels.UID:
            confinement.end_user(self._user.number)
        processes.end(self._alive, END_STAGES)
        for process in self._started:
            process.poll()
        remove_folders(self.folder)
        shutil.rmtree(self._program, ignore_errors=True)

    def _alive(self) -> Set[psutil.Process]:
        """Return the processes to end: those with the mark, and all that descend from this one."""
        return processes.related(f'{MARK}={self._mark}', psutil.Process(), self._kept()) - {self._guardian}

    def _kept(self) -> Set[int]:
        """Return the numbers of the children whose exit codes are asked for elsewhere."""
        return {process.pid for process in (*self._started, self._guardian)}

    def __enter__(self) -> 'Sandbox':
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _check_own(command: Sequence[str], shown: Sequence[Tuple[str, str]]) -> None:
    """Raise CommandError where the file of a command is not among those that a program sees."""
    seen = [*view.SYSTEM, *(place for _, place in shown)]
    for part in command[:2]:
        if os.path.isfile(part) and not view.below(os.path.abspath(part), seen):
            raise CommandError(f'{part} does not belong to the program: it sees its own files, ROS and the messages of '
                               'the workspace. Show it a folder with --packages FOLDER, if you trust it')


class Program:
    """An isolated command that was started."""

    def __init__(self, process: 'subprocess.Popen[bytes]', report: int, inside: bool, most: limits.Limits,
                 folder: str, end: Callable[[], object]) -> None:
        """``report``: where bubblewrap says, ``inside`` a namespace, that it has begun; ``folder``: what it writes.

        ``end()`` ends all its processes.
        """
        self.process, self._inside, self._folder, self._end = process, inside, folder, end
        self._report, self._said = report, b''
        self._meter = limits.Meter(most, self.ids, confinement.disk_used if inside else self._disk_used)
        self._most, self._met = most, ''
        threading.Thread(target=self._watch, name='limits', daemon=True).start()

    def ids(self) -> Set[int]:
        """Return the numbers of its processes that run, without those of bubblewrap."""
        found = processes.descendant_ids(self.process.pid)
        return found - self._first() if self._inside else found | {self.process.pid}

    def _first(self) -> Set[int]:
        """Return the number of the first process inside, which belongs to bubblewrap."""
        self._read_report()
        return {int(text) for text in re.findall(rb'"child-pid": (\d+)', self._said)}

    def _read_report(self) -> None:
        with contextlib.suppress(BlockingIOError):
            os.set_blocking(self._report, False)
            while True:
                read = os.read(self._report, CHUNK)
                if not read:
                    break
                self._said += read

    def exit_code(self) -> Optional[int]:
        """Return its exit code, or None while it runs; raise IsolationError where it was never started."""
        code = self.process.poll()
        if code is not None and self._inside and not self._first():
            raise IsolationError(f'{levels.BUBBLEWRAP} could not isolate the program (exit code {code})')
        return code

    def met(self) -> str:
        """Return which limit it has met, or ''; it is then ended."""
        code = self.process.poll()
        name = limits.of_signal(code) if code is not None else ''
        return self._met or (limits.reason(name, self._most._asdict()[name]) if name else '')

    def _watch(self) -> None:
        with contextlib.suppress(OSError):  # which takes root; beside hundreds of busy processes it would come late
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), URGENT)
        while self.process.poll() is None:
            self._met = self._meter.look()
            if self._met:
                with contextlib.suppress(psutil.Error):
                    self._end()
                return
            time.sleep(limits.PERIOD)

    def cpu(self) -> float:
        """Return the processor time [s] that its processes have used."""
        return self._meter.cpu()

    def _disk_used(self, _numbers: Any) -> float:
        return limits.folder_size(self._folder)


def remove_folders(folder: str) -> None:
    """Remove what a Sandbox has made in its folder."""
    for name in (*FOLDERS.values(), PROGRAM):
        shutil.rmtree(os.path.join(folder, name), ignore_errors=True)


class Student:
    """The student's program with its output: ``lines`` (OutputLine), ``dropped`` (lines that were too many)."""

    def __init__(self, sandbox: Sandbox, command: Sequence[str], now: Callable[[], float]) -> None:
        """``now()`` returns the simulated time [s] to book a line with."""
        self.lines: List[OutputLine] = []
        self.dropped, self._now = 0, now
        try:
            self._program = sandbox.start(command)
        except OSError as error:
            raise CommandError(f'{shlex.join(command)} cannot be started: {error.strerror}') from None
        self.process = self._program.process
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
        """Return its exit code, or None while it runs; raise IsolationError where it was never started."""
        return self._program.exit_code()

    def met(self) -> str:
        """Return which limit it has met, or ''; it is then ended."""
        return self._program.met()

    def cpu(self) -> float:
        """Return the processor time [s] that its processes have used."""
        return self._program.cpu()

    def several(self) -> bool:
        """Return whether it has started other processes."""
        return len(self._program.ids()) > 1

    def runs(self) -> Optional[Dict[int, int]]:
        """Return {process: how long it has run [ns]} of it and what it has started; None while one runs."""
        runs: Dict[int, int] = {}
        for process in self._program.ids():
            with contextlib.suppress(Gone), contextlib.closing(ProcessThreads(process)) as threads:
                if not threads.sleeps():
                    return None
                runs[process] = threads.ran()
        return runs

    def trouble(self) -> str:
        """Return how it failed, '' while it runs and after success.

        rospy.signal_shutdown in a callback ends a loop in the main thread with an exception, which is not a failure.
        """
        if self.met():
            return self.met()
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
        self._looked: Optional[Dict[int, int]] = None

    def look(self) -> float:
        """Return for how long [s] nothing of it has run, or just to poll."""
        looked, before, past = self._student.runs(), self._looked, self._idle.waited
        self._looked = looked
        if looked is None or before is None:
            self._idle = ActiveTimer()
        else:
            ran = sum(total - before.get(process, 0) for process, total in looked.items())  # [ns]
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
    check_command(command)
    program, *arguments = command
    if program.endswith('.launch') and os.path.isfile(program):
        program, arguments = 'roslaunch', list(command)
    if not os.path.exists(program):
        return _by_name(program, arguments)
    program = os.path.abspath(program)
    _check_file(program)
    source = student_files.read(program)
    if not program.endswith('.py') and not _is_python(source):
        if not os.access(program, os.X_OK):
            raise CommandError(str(findings.not_executable(program)))
        if source.startswith(b'#!') and b'\r' in source.split(b'\n', 1)[0]:
            raise CommandError(str(findings.windows_line_ends(program)))
        return [program, *arguments], []
    try:
        return [sys.executable, program, *arguments], _remarks(program, student_files.whole(program))
    except student_files.NoFile as error:
        raise CommandError(f'{program}: {error}') from None


def check_command(command: Sequence[str]) -> None:
    """Raise CommandError for what Linux could not start, whatever the program is."""
    if any('\0' in part for part in command):
        raise CommandError('the command contains the character NUL (its code is 0); remove it')
    length = sum(map(len, map(os.fsencode, command)))
    if length > LONGEST_COMMAND:
        raise CommandError(f'the command has {length:,} bytes; at most {LONGEST_COMMAND:,} can be started')


def _check_file(program: str) -> None:
    """Raise CommandError for what is no file that can be read."""
    if os.path.isdir(program):
        raise CommandError(f'{program} is a folder; name the program in it')
    if not os.path.isfile(program):
        raise CommandError(f'{program} is no file')
    if not os.access(program, os.R_OK):
        raise CommandError(f'{program} cannot be read; type: chmod +r {shlex.quote(program)}')


def _by_name(program: str, arguments: List[str]) -> Tuple[List[str], List[str]]:
    """As runnable(), of a program that is no file here."""
    if program in ('python', 'python3') and arguments and os.path.isfile(arguments[0]):
        return runnable(arguments)
    if program in ('python', 'python3') and arguments and arguments[0].endswith('.py'):
        program = arguments[0]
    if '/' not in program and not program.endswith('.py') and shutil.which(program):
        on_screen = ['--screen'] if program == 'roslaunch' else []  # because log output counts as printed output
        return [program, *on_screen, *from_here(program, arguments)], []
    raise MissingProgram(f'{program} does not exist (current folder: {os.getcwd()})', program)


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
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        line = getattr(error, 'lineno', None)
        what = getattr(error, 'msg', None) or error
        raise CommandError(f'{os.path.basename(program)}{f", line {line}" if line else ""}: '
                           f'{type(error).__name__}: {what}') from None
    return list(map(str, programs.faults(program, source)))
