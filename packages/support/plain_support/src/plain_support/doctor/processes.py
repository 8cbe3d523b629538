"""Processes and the TCP ports on which they listen, from /proc. Linux; needs only Python."""
import contextlib
import glob
import ipaddress
import itertools
import os
import pwd
from typing import Dict, Iterator, List, NamedTuple, Optional, Tuple

from plain_support import sockets


class Process(NamedTuple):
    """A process; ``environment`` is empty if this user may not read it."""

    pid: int
    user: int
    parent: int
    session: int
    name: str
    command: Tuple[str, ...]
    environment: Dict[str, str]

    def __str__(self) -> str:
        return f'{self.name} (process {self.pid})'


class Listener(NamedTuple):
    """A listening TCP socket; ``process`` is None if this user may not see it."""

    address: str
    port: int
    user: int
    process: Optional[Process]

    @property
    def holder(self) -> str:
        """Return a description of its process, for texts."""
        return str(self.process) if self.process else f'a process of the user {user_name(self.user)}'

    @property
    def local(self) -> bool:
        return ipaddress.ip_address(self.address).is_loopback


def user_name(user: int) -> str:
    """Return the name of a user, or the number if there is none."""
    try:
        return pwd.getpwuid(user).pw_name
    except KeyError:
        return str(user)


def all_processes() -> Iterator[Process]:
    """Yield the processes that this user may see."""
    for folder in glob.glob('/proc/[0-9]*'):
        with contextlib.suppress(OSError, ValueError):
            yield _process(folder)


def age(pid: int) -> float:
    """Return how long [s] a process has been running; 0 if it has ended."""
    try:
        with open(f'/proc/{pid}/stat', encoding='utf-8', errors='replace') as stat, open('/proc/uptime') as uptime:
            started = int(stat.read().rpartition(')')[2].split()[19])  # in ticks of the clock since the system started
            return float(uptime.read().split()[0]) - started / os.sysconf('SC_CLK_TCK')
    except OSError:
        return 0.0


def listeners() -> List[Listener]:
    """Return all listening TCP sockets of this machine."""
    owners = _owners()
    found = []
    for columns in itertools.chain.from_iterable(map(sockets.rows, sockets.TABLES)):
        if columns[sockets.STATE] == sockets.LISTENS:
            pid, process = owners.get(columns[sockets.INODE]), None
            with contextlib.suppress(OSError, ValueError):
                process = _process(f'/proc/{pid}') if pid else None
            found.append(Listener(*sockets.parsed(columns[sockets.LOCAL]), int(columns[sockets.USER]), process))
    return found


def master_of_user(workspace: str) -> Optional[Tuple[str, str]]:
    """Return (who, URI) of a ROS master that this user runs, not a ./run demo or test of ``workspace``; or None."""
    for listener in listeners():
        process = listener.process
        if (process and process.user == os.geteuid() and any(word.endswith('rosmaster') for word in process.command[:2])
                and not (workspace and process.environment.get('ROS_HOME', '').startswith(workspace))):
            return str(process), f'http://localhost:{listener.port}'
    return None


def _owners() -> Dict[str, int]:
    """Return {inode of a socket: number of a process that has it}."""
    found = {}
    for link in glob.glob('/proc/[0-9]*/fd/*'):
        with contextlib.suppress(OSError):
            target = os.readlink(link)
            if target.startswith('socket:['):
                found[target[len('socket:['):-1]] = int(link.split('/')[2])
    return found


def _process(folder: str) -> Process:
    with open(f'{folder}/stat', encoding='utf-8', errors='replace') as file:
        before, _, after = file.read().rpartition(')')
    fields = after.split()
    environment: Dict[str, str] = {}
    with contextlib.suppress(OSError):
        for entry in _parts(f'{folder}/environ'):
            name, _, value = entry.partition('=')
            environment[name] = value
    return Process(int(before.split()[0]), os.stat(folder).st_uid, int(fields[1]), int(fields[3]),
                   before.partition('(')[2], tuple(_parts(f'{folder}/cmdline')), environment)


def _parts(path: str) -> List[str]:
    with open(path, 'rb') as file:
        return file.read().decode(errors='replace').rstrip('\0').split('\0')
