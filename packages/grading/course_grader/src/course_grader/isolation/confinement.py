"""The command line that starts a program at a level of isolation, and the user id that it gets.

Nothing here is secret: the kernel enforces the isolation.
"""
import contextlib
import fcntl
import os
import signal
import stat
import subprocess
from typing import Dict, Iterable, List, Mapping, NamedTuple, Optional, Sequence, Tuple

from course_grader.isolation import levels, limits, view
from course_grader.isolation.limits import MEGABYTE, Limits

HOME, TEMPORARY = '/student', '/tmp'  # inside
KILLS = 3  # one is enough, unless a process is just being started
LOCKS = '/run/turtle_robotont', '/tmp/turtle_robotont_users'  # folders of root: the first available one; the process
                                                              # that has locked a file there owns the user
WRITABLE = '/tmp', '/var/tmp', '/dev/shm', '/dev/mqueue', '/run/lock'  # folders in which every user may write


class Isolation(NamedTuple):
    """How a grading is isolated: the level, the limits, and the program's own files ((): those of the command).

    ``users``: whether root may become another user here.
    """

    level: str = levels.NONE
    limits: Limits = Limits()
    own: Tuple[str, ...] = ()
    users: bool = True


NO_ISOLATION = Isolation()


class User:
    """A user id that no other grading of this machine uses, until ``close`` or the end of this process.

    The lock is a file that only root can open, in any network, so no program can take it.
    """

    def __init__(self) -> None:
        """Reserve a free user id; raise OSError if none is free."""
        folder = _lock_folder()
        first = os.getpid() % len(levels.USERS)
        for number in (*levels.USERS[first:], *levels.USERS[:first]):
            self._lock = os.open(os.path.join(folder, f'user_{number}'), os.O_RDWR | os.O_CREAT, 0o600)
            try:
                fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                os.close(self._lock)
                continue
            self.number = number
            return
        raise OSError('no user id is free')

    def close(self) -> None:
        os.close(self._lock)


def _lock_folder() -> str:
    """Return the first of LOCKS that only this user can write to; raise OSError if there is none."""
    for folder in LOCKS:
        with contextlib.suppress(OSError):
            os.makedirs(folder, mode=0o700, exist_ok=True)
            found = os.lstat(folder)
            if stat.S_ISDIR(found.st_mode) and found.st_uid == os.geteuid() and not found.st_mode & 0o077:
                return folder
    raise OSError(f'no folder for the locks of user ids can be made: {" or ".join(LOCKS)}')


def confined(isolation: Isolation, command: Sequence[str], environment: Mapping[str, str],
             shown: Iterable[Tuple[str, str]] = (), user: Optional[int] = None, report: int = -1,
             hidden: Iterable[str] = ()) -> List[str]:
    """Return the command line that starts ``command``.

    ``shown``: what it sees besides the system, see view.shown(); ``user``: its user id; ``report``: the file descriptor
    on which bubblewrap reports its start; ``hidden``: folders that are empty inside.
    """
    inside = isolation.level == levels.NAMESPACE
    counted = limits.counts_processes(user is not None, inside)
    line = [*limits.starter(isolation.limits, counted), '--', *_rights(user), *command]
    if not inside:
        return line
    return [*_bubblewrap(isolation.limits, environment, list(shown), user is None, report, hidden), '--', *line]


def _rights(user: Optional[int]) -> List[str]:
    own = [] if user is None else [f'--reuid={user}', f'--regid={user}', '--clear-groups', '--bounding-set=-all',
                                   '--inh-caps=-all']
    return ['setpriv', '--no-new-privs', *own]


def _bubblewrap(most: Limits, environment: Mapping[str, str], shown: Sequence[Tuple[str, str]], own_users: bool,
                report: int, hidden: Iterable[str]) -> List[str]:
    size = str(most.disk * MEGABYTE)
    bound = [place for _, place in shown]
    line = [levels.BUBBLEWRAP, '--unshare-pid', '--unshare-ipc', '--unshare-uts', '--die-with-parent',
            *(['--unshare-user'] if own_users else []), '--json-status-fd', str(report), *_system(),
            '--proc', '/proc', '--dev', '/dev']
    for place in (HOME, TEMPORARY, '/dev/shm'):
        line += ['--perms', '1777', '--size', size, '--tmpfs', place]
    for place in view.parents(bound):  # without this, bubblewrap makes them for its own user only
        line += ['--perms', '0755', '--dir', place]
    for source, place in shown:
        line += ['--ro-bind', source, place]
    for place in hidden:
        if os.path.isdir(place) and view.below(place, bound):
            line += ['--size', '4096', '--tmpfs', place]
    for place in view.folders(environment):
        line += ['--perms', '0777', '--dir', place]
    return [*line, '--remount-ro', '/dev', '--remount-ro', '/', '--chdir', environment['PWD']]


def _system() -> List[str]:
    """Return bubblewrap's options for the folders that every program sees."""
    line = ['--perms', '0755', '--dir', '/etc']
    for place in view.SYSTEM:
        if os.path.islink(place):
            line += ['--symlink', os.readlink(place), place]
        elif os.path.isdir(place):
            line += ['--ro-bind', place, place]
    for name in view.SETTINGS:
        line += ['--ro-bind-try', f'/etc/{name}', f'/etc/{name}']
    return line


def end_user(number: int) -> None:
    """End all processes of a user, however many: a process of that user signals all of them at once."""
    child = os.fork()
    if not child:
        try:
            levels.become(number)
            for _ in range(KILLS):
                os.kill(-1, signal.SIGKILL)  # except this process; ProcessLookupError: none is left
        finally:
            os._exit(0)
    os.waitpid(child, 0)


def written(folder: str, user: Optional[int]) -> float:
    """Return the size [MB] of all files in a folder, or with a ``user`` of those of this user there and in WRITABLE."""
    line = ['find', folder] if user is None else [*find_written(folder), *_closed(user), '-o', '-user', str(user)]
    found = subprocess.run([*line, '-printf', '%b '], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                           stderr=subprocess.DEVNULL, check=False)
    return sum(map(int, found.stdout.split())) * 512 / MEGABYTE


def remove_written(folder: str, user: int) -> None:
    """Remove the files of a user, of whom no process runs any more."""
    found = subprocess.run([*find_written(folder), '-user', str(user), '-prune', '-print0', '-o', *_closed(user)],
                           stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False)
    subprocess.run(['xargs', '-0', '-r', 'rm', '-rf', '--'], input=found.stdout, stderr=subprocess.DEVNULL,
                   check=False)


def find_written(folder: str) -> List[str]:
    """Return the start of a find(1) below a folder and those of WRITABLE.

    It gets through folders of any depth, as os.walk and shutil do not.
    """
    places = dict.fromkeys(map(os.path.realpath, (folder, *WRITABLE)))
    return ['find', *filter(os.path.isdir, places), '-xdev', '-mindepth', '1']


def _closed(user: int) -> List[str]:
    """Return the expression that leaves out folders in which a user cannot have written."""
    return ['(', '-type', 'd', '!', '-perm', '-o+w', '!', '-user', str(user), '-prune', ')']


def disk_used(numbers: Iterable[int]) -> float:
    """Return the size [MB] of the files that the processes of a namespace have written."""
    for number in sorted(numbers, reverse=True):  # the newest is inside, whatever started it
        with contextlib.suppress(OSError):
            used: Dict[int, float] = {}
            for place in (HOME, TEMPORARY, '/dev/shm'):
                there = f'/proc/{number}/root{place}'
                found = os.statvfs(there)
                used[os.stat(there).st_dev] = (found.f_blocks - found.f_bfree) * found.f_frsize / MEGABYTE
            return sum(used.values())
    return 0.0
