"""Masters, nodes under test and probes of a bench as child processes. The bench itself never imports rospy."""
import json
import os
import subprocess
import sys
import time
from dataclasses import dataclass

from processes import BenchError, Child, Cpu
from rospy_support.own_master import MasterError, start_master

FIND_DEADLINE = 20.0  # [s] for catkin_find
COME_UP = 60.0  # [s] until a node answers; probes give up before that with a better text
SETTLE = 1.0  # [s] after a change before a window opens
RUN_PROBE = 'import probing; probing.main()'


@dataclass(frozen=True)
class Measurement:
    """One measurement of a suite.

    run(subject, scale) -> {figure key: samples}; in_process: it needs no node, so it is run for ours only.
    """

    run: object
    about: str
    in_process: bool = False


@dataclass(frozen=True)
class Scale:
    """How much to measure: windows [s], samples of a kind in a round, starts in a round."""

    window: float
    samples: int = 0
    starts: int = 0


FULL = Scale(window=5.0, samples=150, starts=3)
QUICK = Scale(window=1.5, samples=30, starts=1)


def package_path(executable, inherited):
    """Return ROS_PACKAGE_PATH for an executable: its own catkin workspace before the inherited ones.

    A turtlesim_node of another workspace looks up its package's files by this path; without it, it would take those
    of the workspace of this bench. Unknown layouts leave `inherited` as it is.
    """
    prefix = os.path.dirname(os.path.dirname(os.path.dirname(executable)))  # PREFIX/lib/PACKAGE/EXECUTABLE
    try:
        with open(os.path.join(prefix, '.catkin'), encoding='utf-8') as file:
            sources = file.read().strip()  # a devel space names its sources, an install space has none
    except OSError:
        return inherited
    return os.pathsep.join([*(sources.split(';') if sources else [os.path.join(prefix, 'share')]),
                            *([inherited] if inherited else [])])


def find_node(package, executable):
    """Return the command that ``rosrun package executable`` would run; raise BenchError if there is none."""
    command = ['catkin_find', '--first-only', '--libexec', '--share', package, executable]
    try:
        found = subprocess.run(command, capture_output=True, text=True, timeout=FIND_DEADLINE, check=False).stdout
    except (OSError, subprocess.TimeoutExpired) as error:
        raise BenchError(f'catkin_find does not work ({error}). Run this through ./run bench.') from error
    if not found.strip():
        raise BenchError(f'No executable {executable} in package {package}. Build it with ./run build.')
    return [found.splitlines()[0]]


class Subject:
    """A node under test and its master. side: 'ours' or 'peer'; command: list; folder: for logs, removed later."""

    def __init__(self, side, command, folder):
        self.side, self.command, self.folder = side, command, folder
        self._env = dict(os.environ, ROS_HOSTNAME='localhost', ROS_LOG_DIR=folder, ROS_HOME=folder,
                         QT_QPA_PLATFORM='offscreen')
        for name in ('DISPLAY', 'ROS_NAMESPACE', 'ROS_IP'):
            self._env.pop(name, None)
        try:
            self.uri, self.master = start_master(lambda command: Child(f'master of {side}', command, self._env, folder))
        except MasterError as error:
            raise BenchError(str(error)) from None
        self._env['ROS_MASTER_URI'] = self.uri
        self._node_env = dict(self._env)
        self._node_env['ROS_PACKAGE_PATH'] = package_path(command[0], self._env.get('ROS_PACKAGE_PATH', ''))

    def start(self, name, command, stdin=subprocess.DEVNULL, **environment):
        """Start any program beside the node under test; return a Child."""
        return Child(name, command, {**self._node_env, **environment}, self.folder, stdin=stdin)

    def node(self, *arguments, before=()):
        """Start the node under test, after the words of ``before``; return a Child, for a with statement."""
        return self.start(f'node of {self.side}', [*before, *self.command, *arguments])

    def other(self, command):
        """Start another node that the one under test works with; return a Child, for a with statement."""
        return self.start(f'other node of {self.side}', command)

    def probe(self, module, task, **arguments):
        """Start a task of a probe (see probing.py), which prints one JSON document per line; return a Child."""
        command = [sys.executable, '-c', RUN_PROBE, module, task, json.dumps(arguments)]
        # A package of catkin that the bench has imported has put its sources first: compiled modules are not there
        path = filter(None, [self._env.get('PYTHONPATH'), *sys.path])
        env = dict(self._env, PYTHONPATH=os.pathsep.join(path))
        return Child(f'{module} {task}', command, env, self.folder, lines=True)

    def ask(self, node, module, task, patience=0.0, **arguments):
        """Run a probe while ``node`` runs; return its only answer, within ``patience`` [s] after COME_UP."""
        with self.probe(module, task, **arguments) as probe:
            return answer(probe, patience, node)


def answer(probe, patience=0.0, *watched):
    """Return the next answer of a probe within COME_UP and ``patience`` [s], while the ``watched`` children run."""
    line = probe.next_line(time.monotonic() + COME_UP + patience, watched)
    try:
        return json.loads(line)
    except ValueError as error:
        raise BenchError(f'{probe.name} printed {line!r}, expected JSON. Its last lines:\n{probe.tail()}') from error


def seconds_to_first(subject, scale, topic, *arguments):
    """Return the times [s] from the start of the node to the first message at a subscriber that is there before."""
    seconds = []
    for _ in range(scale.starts):
        with subject.probe('topic_probe', 'first', topic=topic) as waiting:
            answer(waiting)
            begun = time.perf_counter()
            with subject.node(*arguments) as node:
                seconds.append(answer(waiting, 0.0, node)['first'] - begun)
    return seconds


def listened(subject, node, scale, **arguments):
    """Return (CPU [% of a core] of a node, stamps [s] of a topic's messages) while it has one subscriber."""
    with subject.probe('topic_probe', 'listen', seconds=scale.window, **arguments) as probe:
        answer(probe, 0.0, node)
        time.sleep(SETTLE)
        cpu = Cpu(node.pid)
        time.sleep(scale.window)
        return cpu.percent(), answer(probe, scale.window, node)['stamps']
