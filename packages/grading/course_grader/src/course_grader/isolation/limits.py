"""The resources that a program may use. A program that exceeds a limit is ended, and fails with that reason.

The kernel enforces most of them (prlimit), for each process; a Meter measures all processes of a program together.
"""
import argparse
import contextlib
import math
import os
import platform
import re
from typing import Callable, Collection, Dict, List, NamedTuple, Optional, Sequence, Tuple

MEGABYTE = 1 << 20
PERIOD = 0.5  # [s] of wall time between two polls of a Meter; if shorter, lockstep counts the Meter as busy
NAMESPACE_COUNT = (5, 14)  # the Linux version since which processes are counted per user namespace
TICKS = os.sysconf('SC_CLK_TCK')  # a second
PAGE = os.sysconf('SC_PAGE_SIZE')  # [bytes]
MANY_BUSY = 8  # threads that want a core at the same time, twice in a row; honest samples have at most 3
HEADROOM = 32  # processes that the kernel allows beyond the limit, so that a Meter can see that it is exceeded
CPU_ALLOWANCE = 30.0  # [s] of processor time beyond that of the exercise, for imports


class Limits(NamedTuple):
    """Processes and threads; MB of one file, of all files, of memory; s of processor time (0: unlimited)."""

    processes: int = 256
    file_size: int = 64
    disk: int = 128
    memory: int = 2048
    cpu: int = 0


MEANINGS = {'processes': ('N', 'processes and threads at a time'),
            'file_size': ('MB', 'size of one file'),
            'disk': ('MB', 'size of all its files'),
            'memory': ('MB', 'memory of all its processes'),
            'cpu': ('SECONDS', f'processor time; default: the time of the exercise + {CPU_ALLOWANCE:g} s')}
HIGHEST = 10 ** 6


def add_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group('limits of a program, which fails when it exceeds one')
    for name, default in Limits()._asdict().items():
        unit, meaning = MEANINGS[name]
        group.add_argument(option(name), type=positive, default=default, metavar=unit,
                           help=meaning + ('' if name == 'cpu' else f' (default: {default})'))


def option(name: str) -> str:
    return f'--max-{name.replace("_", "-")}'


def chosen(options: argparse.Namespace) -> Limits:
    return Limits(**{name: getattr(options, f'max_{name}') for name in Limits._fields})


def positive(text: str) -> int:
    """Return a typed whole number above 0, as an option of a command line."""
    if not text.isdecimal() or not 1 <= int(text) <= HIGHEST:
        raise argparse.ArgumentTypeError(f'it is {text}; it must be a whole number from 1 to {HIGHEST}')
    return int(text)


def seconds(text: str) -> float:
    """Return a typed time [s] above 0, as an option of a command line."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f'it is {text}; it must be a number above 0')
    return value


def counts_processes(user_is_own: bool, in_namespace: bool, release: str = '') -> bool:
    """Return whether the kernel can count the program's processes separately from those of the user who grades."""
    found = re.match(r'(\d+)\.(\d+)', release or platform.release())
    return user_is_own or in_namespace and found is not None and tuple(map(int, found.groups())) >= NAMESPACE_COUNT


def starter(limits: Limits, counted: bool) -> List[str]:
    """Return the command that starts another one with limits; ``counted``: see counts_processes()."""
    line = ['choom', '-n', '1000', '--', 'prlimit', '--core=0', f'--fsize={limits.file_size * MEGABYTE}',
            f'--data={limits.memory * MEGABYTE}']
    return [*line, *([f'--cpu={limits.cpu}'] if limits.cpu else []),
            *([f'--nproc={limits.processes + HEADROOM}'] if counted else [])]


class Meter:
    """Measures what all processes of a program use together."""

    def __init__(self, limits: Limits, find: Callable[[], Collection[int]],
                 disk: Callable[[Collection[int]], float]) -> None:
        """``find()`` returns the ids of the processes; ``disk(ids)`` the size of all files [MB]."""
        self._limits, self._find, self._disk = limits, find, disk
        self._cpu: Dict[int, float] = {}  # [s] of each process, also of those that have ended
        self._with_children = 0.0  # [s] of the running ones and of their ended children
        self._was_busy = False  # in the last poll
        self.memory = 0.0  # [MB], the highest so far
        self.greedy = False  # it wanted many cores at a time

    def poll(self) -> Optional[str]:
        """Return which limit the program has exceeded, or None; a greedy program runs only on cores that are idle."""
        numbers = self._find()
        busy = sum(map(_runnable, numbers)) >= MANY_BUSY
        self.greedy = self.greedy or busy and self._was_busy
        self._was_busy = busy
        if self.greedy:
            _run_when_idle(numbers)
        if sum(map(_threads, numbers)) >= self._limits.processes:  # with many processes, everything else takes long
            return reason('processes', self._limits.processes)
        times = {number: _cpu_times(number) for number in numbers}
        self._cpu.update({number: own for number, (own, _) in times.items()})
        self._with_children = max(self._with_children, sum(own + ended for own, ended in times.values()))
        used = {'memory': _memory(numbers, self._limits.memory), 'cpu': self.cpu(), 'disk': self._disk(numbers)}
        self.memory = max(self.memory, used['memory'])
        limits = self._limits._asdict()
        return next((reason(name, limits[name]) for name, value in used.items() if 0 < limits[name] <= value), None)

    def cpu(self) -> float:
        """Return the processor time [s] of all processes seen so far."""
        return max(self._with_children, sum(self._cpu.values()))


def reason(name: str, limit: int) -> str:
    unit, meaning = MEANINGS[name]
    unit = {'N': '', 'MB': ' MB', 'SECONDS': ' s'}[unit]
    return f'the program exceeded a limit: {meaning.partition(";")[0]}: {limit}{unit} ({option(name)})'


def of_signal(code: int) -> Optional[str]:
    """Return which limit an exit code tells (below 0, or from 128: a signal), or None."""
    number = -code if code < 0 else code - 128
    return {24: 'cpu', 25: 'file_size'}.get(number)  # SIGXCPU, SIGXFSZ


def _fields(number: int, below: str = '') -> Sequence[bytes]:
    """Return the fields of /proc/NUMBER/stat from the third on; of a thread ``below`` its process."""
    try:
        with open(f'/proc/{below}{number}/stat', 'rb') as file:
            return file.read().rpartition(b')')[2].split()
    except OSError:
        return ()


def _cpu_times(number: int) -> Tuple[float, float]:
    """Return the processor time [s] of a process, and that of its ended children."""
    user, system, *ended = [int(field) / TICKS for field in _fields(number)[11:15]] or (0.0, 0.0)
    return user + system, sum(ended)


def _threads(number: int) -> int:
    return int((_fields(number)[17:18] or [b'0'])[0])


def _runnable(number: int) -> int:
    """Return how many threads of a process run or want a core."""
    if _threads(number) < MANY_BUSY:
        return int(_fields(number)[:1] == [b'R'])
    return sum(int(_fields(int(thread), f'{number}/task/')[:1] == [b'R']) for thread in _thread_ids(number))


def _thread_ids(number: int) -> List[str]:
    try:
        return os.listdir(f'/proc/{number}/task')
    except OSError:
        return []


def _run_when_idle(numbers: Collection[int]) -> None:
    """Give all threads of processes, and so what they will start, the cores that nobody else wants.

    The fault: hundreds of busy processes leave the gradings beside them a hundredth of a core. A cgroup would do the
    same, but few machines let a program make one. Without privileges, no thread can leave this class.
    """
    for number in numbers:
        for thread in map(int, _thread_ids(number)):
            with contextlib.suppress(OSError):
                if os.sched_getscheduler(thread) != os.SCHED_IDLE:
                    os.sched_setscheduler(thread, os.SCHED_IDLE, os.sched_param(0))


def _memory(numbers: Collection[int], limit: float) -> float:
    """Return the memory [MB] of processes; near the limit, shared memory counts once."""
    simple = sum(int((_fields(number)[21:22] or [b'0'])[0]) for number in numbers) * PAGE / MEGABYTE
    return simple if simple < limit else sum(map(_own_share, numbers))


def _own_share(number: int) -> float:
    """Return the memory [MB] of a process, with its share of shared memory."""
    try:
        with open(f'/proc/{number}/smaps_rollup', encoding='ascii') as file:
            return sum(int(line.split()[1]) for line in file if line.startswith('Pss:')) / 1024
    except OSError:
        return int((_fields(number)[21:22] or [b'0'])[0]) * PAGE / MEGABYTE
