"""Masters, nodes under test and probes of a bench as child processes. The bench itself never imports rospy."""

import json
import os
import shlex
import subprocess
import sys
import time

from processes import BenchError, Child
from rospy_support.own_master import MasterError, start_master

FIND_DEADLINE = 20.0  # [s] for catkin_find
HERE = os.path.dirname(os.path.abspath(__file__))


def package_path(executable, inherited, read=None):
    """ROS_PACKAGE_PATH for an executable: its own catkin workspace before the inherited ones.

    A turtlesim_node of another workspace looks up its package's files by this path; without it, it would take those
    of the workspace of this bench. Unknown layouts leave `inherited` as it is.
    """
    prefix = os.path.dirname(os.path.dirname(os.path.dirname(executable)))  # PREFIX/lib/PACKAGE/EXECUTABLE
    try:
        sources = (read or _read)(os.path.join(prefix, '.catkin'))
    except OSError:
        return inherited
    own = sources.strip().split(';') if sources.strip() else [os.path.join(prefix, 'share')]
    return os.pathsep.join(own + ([inherited] if inherited else []))


def _read(path):
    with open(path, encoding='utf-8') as file:
        return file.read()


def find_node(package, executable):
    """Return the command that ``rosrun package executable`` would run; raise BenchError when there is none."""
    command = ['catkin_find', '--first-only', '--libexec', '--share', package, executable]
    try:
        found = subprocess.run(command, capture_output=True, text=True, timeout=FIND_DEADLINE, check=False).stdout
    except (OSError, subprocess.TimeoutExpired) as error:
        raise BenchError(f'catkin_find does not work ({error}). Run this through ./run bench.') from error
    if not found.strip():
        raise BenchError(f'No executable {executable} in package {package}. Build it with ./run build, '
                         "or name one with --node 'command'.")
    return [found.splitlines()[0]]


class Subject:
    """A node under test and its master. side: 'ours' or 'peer'; command: list; folder: for logs, removed later."""

    def __init__(self, side, command, folder):
        self.side, self.command, self.folder = side, command, folder
        self.uri = self.master = None
        self._env = dict(os.environ, ROS_HOSTNAME='localhost', ROS_LOG_DIR=folder, ROS_HOME=folder,
                         QT_QPA_PLATFORM='offscreen')
        for name in ('DISPLAY', 'ROS_NAMESPACE', 'ROS_IP'):
            self._env.pop(name, None)
        self.start_master()
        self._env['ROS_MASTER_URI'] = self.uri
        self._node_env = dict(self._env)
        self._node_env['ROS_PACKAGE_PATH'] = package_path(command[0], self._env.get('ROS_PACKAGE_PATH', ''))

    def start_master(self):
        """Start the master, after its end on the same port; raise BenchError when it does not answer."""
        port = self.uri and int(self.uri.rpartition(':')[2])
        try:
            self.uri, self.master = start_master(
                lambda command: Child(f'master of {self.side}', command, self._env, self.folder), port)
        except MasterError as error:
            raise BenchError(str(error)) from None

    def start(self, name, command, stdin=subprocess.DEVNULL, **environment):
        """Start any program beside the node under test; return a Child. None removes a variable of the environment."""
        env = {key: value for key, value in {**self._node_env, **environment}.items() if value is not None}
        return Child(name, command, env, self.folder, stdin=stdin)

    def node(self, *arguments):
        """Start the node under test; return a Child, for a with statement."""
        return self.start(f'node of {self.side}', [*self.command, *arguments])

    def other(self, command):
        """Start another node that the one under test works with; return a Child, for a with statement."""
        return self.start(f'other node of {self.side}', command)

    def probe(self, module, *arguments):
        """Start a module of this folder as a client that prints one JSON document per line; return a Child."""
        command = [sys.executable, os.path.join(HERE, module), *(str(argument) for argument in arguments)]
        return Child(f'{module} {arguments[0]}', command, self._env, self.folder, lines=True)


def answer(probe, patience, watched=()):
    """Return the next JSON document of a probe within ``patience`` [s], while the ``watched`` children run."""
    line = probe.next_line(time.monotonic() + patience, watched)
    try:
        return json.loads(line)
    except ValueError as error:
        raise BenchError(f'{probe.name} printed {line!r}, expected JSON. Its last lines:\n{probe.tail()}') from error


def split_command(text):
    """Split a command line as a shell does; raise BenchError for an empty one or an open quote."""
    try:
        command = shlex.split(text)
    except ValueError as error:
        raise BenchError(f'Command {text!r} cannot be read: {error}.') from error
    if not command:
        raise BenchError("The command is empty: give a path and its arguments, such as '/path/to/turtlesim_node'.")
    return command
