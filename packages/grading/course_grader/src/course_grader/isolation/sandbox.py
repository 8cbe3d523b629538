"""Runs a student's program in its own folders, isolated and limited, and ends everything that it started.

A program may start others, detach them, ignore signals and print forever. ``close`` ends all processes in its namespace
or of its user, and all that have the environment variable MARK or descend from this process, until none is left (see
plain_support). If the grader itself is killed, its guardian does the same.

Threads: one reads the output; ``lines`` only grows; copy it before iterating over it.
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
from typing import Callable, Dict, List, Mapping, Optional, Protocol, Sequence, Set, Tuple

import psutil

from course_grader.isolation import confinement, levels, limits, student_files, view
from course_grader.isolation.confinement import NO_ISOLATION, Isolation
from course_grader.rules.observation import OutputLine, Problem
from kinematic_core.timing.idle_threads import Gone, ProcessThreads
from kinematic_core.timing.stall_free_timer import ActiveTimer
from plain_support import processes
from plain_support.doctor import findings, programs

MARK = 'TURTLE_ROBOTONT_GRADING'
SHUT_DOWN = 'rospy.exceptions.ROSInterruptException: '  # the end of a loop after rospy.signal_shutdown
POLLING_SHARE, SHORTEST_POLL = 0.1, 0.02  # share of the time for which an idle program may run to poll; of at least [s]
FOLDERS = {'ROS_HOME': 'ros_home', 'ROS_LOG_DIR': 'log', 'TMPDIR': 'tmp'}  # of the grader itself: variable: folder
PROGRAM = 'program'  # folder of a program without a file system of its own
URGENT = -10  # nice value of the thread that checks the limits
CHUNK = 65536  # [bytes] read at once
MAX_COMMAND_LENGTH = 100_000  # [bytes] with all its arguments; Linux takes 131,071 in one
MAX_LINES, MAX_LINE_LENGTH = 20_000, 2_000  # of the output that is stored; all of it is read
MAX_OUTPUT = 1_000_000  # characters of it; a pose printed 60 times a second for 90 s has 500,000
FIRST_LINE = 256  # [bytes] that Linux reads of a script's first line
END_STAGES = processes.KILL  # at once: output after a request to end does not count
FIND_PACKAGES = 'rosrun', 'roslaunch'  # programs that search the packages of a student
COMMAND = '.cmd'  # ending of a file with one command line
SHELL_ENDINGS = '.sh', '.bash'
ANSI = re.compile(r'\x1b\[[0-9;]*[A-Za-z]')
ROSCONSOLE = re.compile(r'^\[ ?([A-Z]+)\] \[[^\]]*\](?: \[[^\]]*\])?: ')  # the prefix of a message that rospy logs


class ProcessLike(Protocol):
    """A process-like object, such as a Popen."""

    pid: int

    def poll(self) -> Optional[int]:
        """Return the exit code, or None while the process runs."""


class CommandError(ValueError):
    """A command cannot be run at all; the text says why and what to do."""


class MissingProgram(CommandError):
    """The program does not exist; ``program`` is the part of the command that names it."""

    def __init__(self, text: str, program: str = '') -> None:
        super().__init__(text)
        self.program = program


class IsolationError(RuntimeError):
    """The program could not be isolated, and was not started."""


class Sandbox:
    """Folders, environment and processes of one grading; use it in a with statement."""

    def __init__(self, folder: str, environment: Mapping[str, str], mark: str = '',
                 isolation: Isolation = NO_ISOLATION, hidden: Sequence[str] = ()) -> None:
        """``folder`` takes everything that the grader writes.

        ``environment``: that of all processes; ``mark``: the value of MARK in it, by default a new one; ``hidden``:
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
        self.user = self._user.number if self._user else None  # user id of the program, if it has its own
        self._program = os.path.join(self.folder, PROGRAM)
        if isolation.level == levels.UID:  # where its user can go
            self._program = tempfile.mkdtemp(prefix='turtle_robotont_', dir=view.temporary())
            os.chmod(self._program, 0o711)
        self._children: List[ProcessLike] = []
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
        user = self.user
        try:
            if not inside:
                command, surroundings = self._prepare(command, surroundings, shown, user)
            elif user is not None:
                shown = view.readable(shown, os.path.join(self._program, 'files'), (*self._hidden, self.folder))
        except (OSError, RecursionError) as error:
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
        self._children.append(process)
        return Program(process, receiver, inside, isolation.limits, self.disk_used,
                       lambda: self._end_program(psutil.Process(process.pid)))

    def seen(self) -> List[Tuple[str, str]]:
        """Return what programs see besides the system, see view.shown()."""
        return view.shown(view.environment(self.environment, self._program, ''), self._isolation.own)

    def disk_used(self) -> float:
        """Return the size [MB] of the files that a program without a file system of its own has written."""
        return confinement.written(self._program, self.user if self._isolation.level == levels.UID else None)

    def _prepare(self, command: Sequence[str], surroundings: Dict[str, str], shown: Sequence[Tuple[str, str]],
                 user: Optional[int]) -> Tuple[Sequence[str], Dict[str, str]]:
        """Make the folders of a program that sees all files; return the command and environment for ``user``.

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

    def keep(self, process: ProcessLike) -> None:
        """Adopt a child that was started elsewhere; ``poll()`` returns its exit code."""
        self._children.append(process)

    def close(self) -> None:
        """End everything at once, including processes that resist."""
        self._end_all()
        self._dismiss_guardian()

    def _end_all(self) -> None:
        if self._user and self._isolation.level == levels.UID:
            confinement.end_user(self._user.number)
            confinement.remove_written(self._program, self._user.number)
        processes.end(self._alive, END_STAGES)
        for process in self._children:
            process.poll()
        remove_folders(self.folder)
        _remove([self._program])

    def _alive(self) -> Set[psutil.Process]:
        """Return the processes to end: those with the mark, and all descendants of this one."""
        return processes.related(f'{MARK}={self._mark}', psutil.Process(), self._kept()) - {self._guardian}

    def _kept(self) -> Set[int]:
        """Return the ids of the children whose exit codes are read elsewhere."""
        return {process.pid for process in (*self._children, self._guardian)}

    def __enter__(self) -> 'Sandbox':
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _check_own(command: Sequence[str], shown: Sequence[Tuple[str, str]]) -> None:
    """Raise CommandError unless the program sees the file of its command."""
    seen = [*view.SYSTEM, *(place for _, place in shown)]
    for part in command[:2]:
        if os.path.isfile(part) and not view.below(os.path.abspath(part), seen):
            raise CommandError(f'{part} does not belong to the program: it sees its own files, ROS and the messages of '
                               'the workspace. Show it a folder with --packages FOLDER, if you trust it')


class Program:
    """An isolated command that was started."""

    def __init__(self, process: 'subprocess.Popen[bytes]', report: int, inside: bool, most: limits.Limits,
                 disk_used: Callable[[], float], end: Callable[[], object]) -> None:
        """``report``: the pipe on which bubblewrap reports its start; ``inside``: whether there is a namespace.

        ``disk_used()`` returns the size [MB] of what it has written, without a namespace; ``end()`` ends all its
        processes.
        """
        self.process, self._inside, self._end = process, inside, end
        self._report, self._status = report, b''
        self._meter = limits.Meter(most, self.ids, confinement.disk_used if inside else lambda _: disk_used())
        self._most = most
        self._exceeded: Optional[str] = None
        threading.Thread(target=self._watch, name='limits', daemon=True).start()

    def ids(self) -> Set[int]:
        """Return the ids of its running processes, without those of bubblewrap."""
        found = processes.descendant_ids(self.process.pid)
        return found - self._first() if self._inside else found | {self.process.pid}

    def _first(self) -> Set[int]:
        """Return the id of the first process inside, which belongs to bubblewrap."""
        self._read_report()
        return {int(text) for text in re.findall(rb'"child-pid": (\d+)', self._status)}

    def _read_report(self) -> None:
        with contextlib.suppress(BlockingIOError):
            os.set_blocking(self._report, False)
            while True:
                read = os.read(self._report, CHUNK)
                if not read:
                    break
                self._status += read

    def exit_code(self) -> Optional[int]:
        """Return its exit code, or None while it runs; raise IsolationError if it was never started."""
        code = self.process.poll()
        if code is not None and self._inside and not self._first():
            raise IsolationError(f'{levels.BUBBLEWRAP} could not isolate the program (exit code {code})')
        return code

    def exceeded_limit(self) -> Optional[Problem]:
        """Return the Problem of a program that was ended because it has exceeded a limit, or None."""
        if self._exceeded:
            return Problem(self._exceeded)
        code = self.process.poll()
        name = None if code is None else limits.of_signal(code)
        return Problem(limits.reason(name, self._most._asdict()[name])) if name else None

    def _watch(self) -> None:
        with contextlib.suppress(OSError):  # needs root; without it, hundreds of busy processes would delay the check
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), URGENT)
        while self.process.poll() is None:
            self._exceeded = self._meter.poll()
            if self._exceeded:
                with contextlib.suppress(psutil.Error):
                    self._end()
                return
            time.sleep(limits.PERIOD)

    def cpu(self) -> float:
        """Return the processor time [s] that its processes have used."""
        return self._meter.cpu()

    def memory(self) -> float:
        """Return the highest memory [MB] that its processes were seen to use."""
        return self._meter.memory

    def end(self) -> None:
        """End all its processes."""
        with contextlib.suppress(psutil.Error):
            self._end()

    def greedy(self) -> bool:
        """Return whether it wanted many cores at a time, and since then gets only those that are idle."""
        return self._meter.greedy


def remove_folders(folder: str) -> None:
    _remove([os.path.join(folder, name) for name in (*FOLDERS.values(), PROGRAM)])


def _remove(folders: Sequence[str]) -> None:
    """Remove folders of any depth: shutil.rmtree ends with a RecursionError."""
    subprocess.run(['rm', '-rf', '--', *folders], stdin=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)


class Student:
    """The student's program with its output: ``lines`` (OutputLine), ``dropped`` (lines that were too many)."""

    def __init__(self, sandbox: Sandbox, command: Sequence[str], now: Callable[[], float]) -> None:
        """``now()`` returns the simulated time [s] at which a line was printed."""
        self.lines: List[OutputLine] = []
        self.dropped, self._size, self._now = 0, 0, now
        try:
            self._program = sandbox.start(command)
        except OSError as error:
            raise CommandError(f'{shlex.join(command)} cannot be started: {error.strerror}') from None
        self.process, self.exit_code = self._program.process, self._program.exit_code
        self.exceeded_limit, self.cpu = self._program.exceeded_limit, self._program.cpu
        self.greedy, self.memory, self.end = self._program.greedy, self._program.memory, self._program.end
        self._reader = threading.Thread(target=self._read, name='output', daemon=True)
        self._reader.start()

    def _read(self) -> None:
        output = self.process.stdout
        assert output is not None  # a pipe, without a log
        rest = b''
        for read in iter(lambda: os.read(output.fileno(), CHUNK), b''):
            *lines, rest = re.split(rb'[\r\n]', rest + read)
            for raw in lines:
                self._store(raw)
            while len(rest) > MAX_LINE_LENGTH:  # of a line that never ends
                self._store(rest[:MAX_LINE_LENGTH])
                rest = rest[MAX_LINE_LENGTH:]
        self._store(rest)

    def _store(self, raw: bytes) -> None:
        """Store a line, also one that a carriage return overwrites in a terminal."""
        for start in range(0, len(raw), MAX_LINE_LENGTH):
            if len(self.lines) >= MAX_LINES or self._size >= MAX_OUTPUT:
                self.dropped += 1
                continue
            text = ANSI.sub('', raw[start:start + MAX_LINE_LENGTH].decode('utf-8', 'replace'))
            if text:
                self._size += len(text)
                logged = ROSCONSOLE.match(text)
                self.lines.append(OutputLine(self._now(), text[logged.end():], logged.group(1)) if logged else
                                  OutputLine(self._now(), text))

    def has_children(self) -> bool:
        """Return whether it has started other processes that still run."""
        return len(self._program.ids()) > 1

    def runs(self) -> Optional[Dict[int, int]]:
        """Return {process id: CPU time [ns]} of it and its children; None while one of them runs."""
        runs: Dict[int, int] = {}
        for process in self._program.ids():
            with contextlib.suppress(Gone), contextlib.closing(ProcessThreads(process)) as threads:
                if not threads.sleeps():
                    return None
                runs[process] = threads.ran()
        return runs

    def problem(self) -> Optional[Problem]:
        """Return how it failed; None while it runs and after success.

        rospy.signal_shutdown in a callback ends a loop of the main thread with an exception, which is not a failure.
        """
        exceeded = self.exceeded_limit()
        if exceeded:
            return exceeded
        code = self.exit_code()
        if not code or code == 1 and self.last_output().startswith(SHUT_DOWN):
            return None
        message = self.last_output()
        hint = '; input() does not work here: put all values into the program' if 'EOFError' in message else ''
        return Problem(f'the program ended with exit code {code}: {message}{hint}')

    def drain(self, timeout: float = 1.0) -> None:
        """Wait until all output of a program that has ended is read, at most ``timeout`` [s]."""
        self._reader.join(timeout)

    def last_output(self) -> str:
        """Return the last line of its output, with the position of a traceback."""
        texts = [line.text for line in list(self.lines)]
        last = next((text for text in reversed(texts) if text.strip()), 'it printed nothing')
        positions = [text.strip() for text in texts if re.match(r'\s+File ".*", line \d+', text)]
        return last + (f' ({positions[-1]})' if positions and 'Traceback' in ' '.join(texts) else '')


class ProgramIdleTimer:
    """Measures how long a Student and its children have been idle; poll it often."""

    def __init__(self, student: Student) -> None:
        self._student, self._idle = student, ActiveTimer()
        self._polled: Optional[Dict[int, int]] = None

    def poll(self) -> float:
        """Return for how long [s] none of its processes has run, except to poll."""
        polled, before, past = self._student.runs(), self._polled, self._idle.waited
        self._polled = polled
        if polled is None or before is None:
            self._idle = ActiveTimer()
        else:
            ran = sum(total - before.get(process, 0) for process, total in polled.items())  # [ns]
            if ran > POLLING_SHARE * 1e9 * max(self._idle.elapsed() - past, SHORTEST_POLL):
                self._idle = ActiveTimer()
        return self._idle.elapsed()


def runnable(command: Sequence[str]) -> Tuple[List[str], List[str]]:
    """Return (command to start, remarks) of what a student typed; raise CommandError when it cannot be run.

    A Python file runs with this Python, whatever its mode, first line or line endings, and another script that is not
    executable with its interpreter; the remarks say why rosrun could not run it. A .cmd file stands for its line.
    """
    if command and command[0].endswith(COMMAND) and os.path.isfile(command[0]):
        try:
            return _runnable(command_in(command[0]))
        except (OSError, ValueError) as error:
            raise CommandError(f'{command[0]}: {error}') from None
    return _runnable(command)


def _runnable(command: Sequence[str]) -> Tuple[List[str], List[str]]:
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
        if source.startswith(b'#!') and b'\r' in source.split(b'\n', 1)[0]:
            raise CommandError(str(findings.windows_line_ends(program)))
        if os.access(program, os.X_OK):
            return [program, *arguments], []
        interpreter = interpreter_of(program)
        if not interpreter:
            raise CommandError(str(findings.not_executable(program)))
        return [*interpreter, program, *arguments], [str(findings.not_executable(program))]
    try:
        return [sys.executable, program, *arguments], _remarks(program, student_files.whole(program))
    except student_files.UnreadableFile as error:
        raise CommandError(f'{program}: {error}') from None


def command_in(path: str) -> List[str]:
    """Return the command in a .cmd file, with the full paths of the files beside it; raise OSError or ValueError."""
    lines = [line.strip() for line in student_files.whole(path).decode().splitlines()
             if line.strip() and not line.startswith('#')]
    if len(lines) != 1:
        raise ValueError(f'it contains {len(lines)} command lines; it must contain one')
    check_command(lines)
    program, *arguments = shlex.split(lines[0])
    folder = os.path.dirname(os.path.abspath(path))
    beside = os.path.join(folder, program)
    return [beside if os.path.isfile(beside) else program, *from_here(program, arguments, folder)]


def interpreter_of(program: str) -> List[str]:
    """Return the command that interprets a script, by its first line or its ending; [] if it is not a script."""
    first = student_files.read(program, FIRST_LINE).split(b'\n', 1)[0]
    if first.startswith(b'#!'):
        return os.fsdecode(first[2:]).split()[:2]
    return ['bash'] if program.endswith(SHELL_ENDINGS) else []


def check_command(command: Sequence[str]) -> None:
    """Raise CommandError if Linux could not start a command, whatever the program."""
    if any('\0' in part for part in command):
        raise CommandError('the command contains the character NUL (its code is 0); remove it')
    length = sum(map(len, map(os.fsencode, command)))
    if length > MAX_COMMAND_LENGTH:
        raise CommandError(f'the command has {length:,} bytes; at most {MAX_COMMAND_LENGTH:,} can be started')


def _check_file(program: str) -> None:
    """Raise CommandError unless the program is a readable file."""
    if os.path.isdir(program):
        raise CommandError(f'{program} is a folder; name the program in it')
    if not os.path.isfile(program):
        raise CommandError(f'{program} is not a file')
    if not os.access(program, os.R_OK):
        raise CommandError(f'{program} cannot be read; type: chmod +r {shlex.quote(program)}')


def _by_name(program: str, arguments: List[str]) -> Tuple[List[str], List[str]]:
    """Return (command to start, remarks) for a program that is not a file here; raise CommandError."""
    if program in ('python', 'python3') and arguments and os.path.isfile(arguments[0]):
        return _runnable(arguments)
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
    """Return the arguments for use in another folder: files in ``folder`` with their full paths.

    The first two arguments of rosrun are names, of a package and of its program; all of roslaunch's are names or
    values, unless the first one is a file.
    """
    def there(argument: str) -> str:
        path = os.path.join(folder, argument)
        return os.path.abspath(path) if os.path.isfile(path) else argument
    if program == 'roslaunch' and arguments and there(arguments[0]) == arguments[0]:
        return list(arguments)
    names = 0
    if program == 'rosrun':
        words = [place for place, argument in enumerate(arguments) if not argument.startswith('-')]
        names = words[1] + 1 if len(words) > 1 else len(arguments)
    return [*arguments[:names], *map(there, arguments[names:])]


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
