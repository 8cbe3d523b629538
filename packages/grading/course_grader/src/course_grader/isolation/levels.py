"""The levels of isolation of a student's program, and which one this machine supports.

namespace: each grading has its own network, and the program sees only its own files, ROS and the interfaces.
uid: the program runs as another user, who can neither change the grading nor signal its processes. none: the program
may do everything that the grading user may do.
"""
import argparse
import os
import subprocess
from typing import Callable, NamedTuple, Optional

from course_grader.isolation import network

LEVELS = NAMESPACE, UID, NONE = 'namespace', 'uid', 'none'  # the strongest one first
OPTION, REQUIRED = '--isolation', '--require-isolation'
USERS = range(60_706, 61_184)  # user ids that neither Debian nor systemd assigns (systemd.io/UIDS-GIDS): its homes,
                               # containers and greeters end at 60705, its dynamic users begin at 61184
BUBBLEWRAP = 'bwrap'
TRIAL = ('--unshare-pid', '--unshare-ipc', '--ro-bind', '/', '/', '--proc', '/proc', '--dev', '/dev', '--size',
         '4096', '--tmpfs', '/tmp', '--', 'true')  # all that a grading needs of bubblewrap
WORKS = 'works'
TIME_LIMIT = 10.0  # [s] of the trial, which takes 20 ms


class TooWeak(Exception):
    """This machine cannot isolate as asked; the text says why and what to do."""


class Machine(NamedTuple):
    """Why this machine does not support a level; '': it does."""

    namespace: str = ''
    uid: str = ''


CAPABLE = Machine()


def add_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group('isolation of a program; default: the strongest level that this machine supports')
    group.add_argument(OPTION, choices=LEVELS, metavar='LEVEL', help='use this level: ' + ', '.join(LEVELS))
    group.add_argument(REQUIRED, choices=LEVELS, default=NONE, metavar='LEVEL',
                       help='grade nothing (exit code 3) unless the level is at least this one')


def decide(machine: Machine, wanted: Optional[str] = None, required: str = NONE) -> str:
    """Return the level ``wanted``, or else the strongest that the machine supports.

    Raise TooWeak if the machine does not support it, or it is weaker than ``required``.
    """
    missing = {NAMESPACE: machine.namespace, UID: machine.uid, NONE: ''}
    if wanted and missing[wanted]:
        raise TooWeak(f'{OPTION} {wanted} is not possible here: {missing[wanted]}. docs/grading.md says what it '
                      'needs')
    level = wanted or next(level for level in LEVELS if not missing[level])
    if LEVELS.index(level) > LEVELS.index(required):
        why = '; '.join(f'{name}: {missing[name]}' for name in LEVELS[:LEVELS.index(required) + 1] if missing[name])
        raise TooWeak(f'{REQUIRED} {required} is not possible: programs would be graded at the level {level}'
                      + (f' ({why})' if why else '') + '. docs/grading.md says what it needs')
    return level


def warning(level: str, machine: Machine = CAPABLE) -> str:
    """Return the warning about a level; '' for the strongest one."""
    if level == NAMESPACE:
        return ''
    why = f' ({machine.namespace})' if machine.namespace else ''
    if level == UID:
        return (f'ISOLATION uid{why}: the programs run as another user, in the same network. They can read what all '
                'users of this machine can read')
    return (f'NO ISOLATION{why}: the programs can read and change everything that you can, the results too. '
            'Grade only programs that you trust; docs/grading.md says what isolation needs')


def machine() -> Machine:
    """Return what this machine supports, found by trying. Call it while this process has one thread."""
    no_users = _tried(_try_user)
    return Machine(_tried(lambda: _try_namespace(not no_users)), no_users)


def _tried(trial: Callable[[], str]) -> str:
    """Run a trial in its own process; return why a level is not possible, or ''."""
    receiver, sender = os.pipe()
    child = os.fork()
    if not child:
        try:
            os.write(sender, (trial() or WORKS).encode('utf-8', 'replace')[:4096])
        finally:
            os._exit(0)
    os.close(sender)
    with open(receiver, encoding='utf-8') as file:
        said = file.read().strip()
    os.waitpid(child, 0)
    return '' if said == WORKS else said or 'the trial crashed'


def _try_user() -> str:
    if os.geteuid():
        return 'only root can give a program another user'
    try:
        become(USERS[0])
    except OSError as error:  # in a container, root may be the only user, or may not change it
        return f'root cannot become another user here: {error}'
    return ''


def become(user: int) -> None:
    """Change the user and group of this process permanently to ``user``. Raise OSError."""
    os.setgroups([])
    os.setresgid(user, user, user)
    os.setresuid(user, user, user)


def _try_namespace(users: bool) -> str:
    """``users``: whether root may become another user; if not, bubblewrap maps one in a user namespace."""
    try:
        network.enter_own()
        line = [BUBBLEWRAP, *([] if users else ['--unshare-user']), *TRIAL]
        ended = subprocess.run(line, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                               timeout=TIME_LIMIT, check=False)
    except FileNotFoundError:
        return f'{BUBBLEWRAP} is missing; type: sudo apt-get install bubblewrap'
    except (OSError, subprocess.SubprocessError) as error:
        return f'a network of its own: {error}'
    said = ended.stdout.decode('utf-8', 'replace').strip() or f'{BUBBLEWRAP} ended with {ended.returncode}'
    return said if ended.returncode else ''
