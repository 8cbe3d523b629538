"""Masters that are killed and started again: does every kind of node register again with all its names?"""

import contextlib
import time

import tcpros
from figures import Figure, Target, median
from rostest_support import node_kinds
from trial import Attack
from under_test import TROUBLE, started

LIMIT = 3.0  # [s] within which all are there again
LOST = 20.0  # [s] after which they are not waited for any more
LOG_TIME = 0.5  # [s] without a master, so that nodes notice and log
OWN_TURTLES = {'velocity_publisher': 'turtle2', 'stop_at_x': 'turtle3', 'drive_shape': 'turtle4',
               'teleport_tour': 'turtle5'}  # who drives at once does so on a turtle of its own
APART = 'draw_square',  # calls reset, which takes others' turtles
POLL = 0.02  # [s]


def kinds_of(small):
    """Return the kinds whose registration is checked together."""
    keys = ('turtlesim', 'teleop', 'usb_cam', 'tracker') if small else (
        kind.key for kind in node_kinds.HARDENED if kind.key not in APART)
    return [node_kinds.on_turtle(kind, OWN_TURTLES[kind.key]) if kind.key in OWN_TURTLES else kind
            for kind in node_kinds.in_order(keys)]


def restarts(subject, scale, _rng):
    """Kill the master and start it again, with all kinds of nodes running."""
    return _restart(subject, kinds_of(scale.small), scale.count(50, 2))


def apart(subject, scale, _rng):
    """The same for kinds that disturb others."""
    return _restart(subject, node_kinds.in_order(APART), scale.count(50, 1))


def peer_restarts(subject, scale, _rng):
    """The same for a simulator alone, which may be a peer."""
    return {key.replace('restart', 'alone'): values
            for key, values in _restart(subject, node_kinds.in_order(['turtlesim']), scale.count(10, 1)).items()}


def _restart(subject, kinds, count):
    found = {'restart_ended': [0]}
    with contextlib.ExitStack() as stack:
        nodes = [_start(stack, subject, kind) for kind in kinds]
        _push_against_the_wall(nodes[0])
        for _ in range(count):
            nodes = [node if node.runs() else _start(stack, subject, node.kind) for node in nodes]
            for key, seconds in _times(subject, nodes).items():
                late = seconds is None or seconds > LIMIT
                found.setdefault(f'restart_late_{key}', []).append(int(late))
                found.setdefault('restart_late', []).append(int(late))
                found.setdefault('restart_lost', []).append(int(seconds is None))
                found.setdefault('restart_time', []).append(LOST if seconds is None else seconds)
            found.setdefault('restarts', []).append(1)
            found['restart_ended'].append(sum(not node.runs() and not _has_arrived(node) for node in nodes))
    return found


def _has_arrived(node):
    """Return whether a node has ended because it has driven where it should; another one is started in its place."""
    return node.kind.drives and node.child.process.poll() == 0


def _start(stack, subject, kind):
    """Start a node; return its Node once it is registered."""
    node = stack.enter_context(started(subject, kind))
    node.await_registered()
    if kind.key == 'turtlesim':
        for turtle in sorted(OWN_TURTLES.values()):
            node.call('/spawn', 5.0, 1.0 + int(turtle[-1]), 0.0, turtle)
    return node


def _push_against_the_wall(node):
    """Put a turtle into a corner: a simulator logs all the time while somebody drives it against the wall."""
    if node.kind.key == 'turtlesim':
        node.call('/turtle1/teleport_absolute', 11.0, 11.0, 0.78)


def _times(subject, nodes):
    """Return {key: time [s] from the answer of a new master to the full registration, None for never}.

    A drive that arrives meanwhile is left out.
    """
    before = {node: node.registered() for node in nodes}
    parameters = {node: _given(node) for node in nodes}
    subject.master.kill()
    time.sleep(LOG_TIME)
    subject.start_master()
    begun, left, took = time.monotonic(), list(nodes), {}
    while left and time.monotonic() - begun < LOST:
        left = [node for node in left if not _has_arrived(node)]
        for node in list(left):
            try:
                if _back(node, before[node], parameters[node]):
                    took[node.kind.key] = time.monotonic() - begun
                    left.remove(node)
            except TROUBLE:
                continue
        time.sleep(POLL)
    took.update({node.kind.key: None for node in left})
    return took


def _given(node):
    """Return {name: value} of the parameters on its command line, as the master has them."""
    if node.subject.side != 'ours':
        return {}
    return {name: node.master.getParam(tcpros.CALLER, name)[2] for name in node.kind.parameters}


def _back(node, before, parameters):
    now = node.registered()
    return all(had <= has for had, has in zip(before, now)) and all(
        node.master.getParam(tcpros.CALLER, name)[::2] == [1, value] for name, value in parameters.items())


ATTACKS = {
    'restarts': Attack(restarts, 'every kind of node, kill -9 of the master', peer=False),
    'apart': Attack(apart, 'the same with draw_square', peer=False),
    'alone': Attack(peer_restarts, 'the same with a turtle simulator alone'),
}
FIGURES = (
    Figure('restarts of the master, kinds of nodes together', 'restarts', '', sum),
    *(Figure(f'{kind.key}: not registered within {LIMIT:g} s', f'restart_late_{kind.key}', 'times', sum,
             Target('at_most', 0)) for kind in node_kinds.HARDENED),
    Figure('never registered again', 'restart_lost', '', sum, Target('at_most', 0)),
    Figure('nodes that ended', 'restart_ended', '', sum, Target('at_most', 0)),
    Figure('registered again, median', 'restart_time', 's', median, Target('below', LIMIT)),
    Figure('registered again, longest', 'restart_time', 's', max, Target('below', LIMIT)),
    Figure('a simulator alone: never registered again', 'alone_lost', '', sum, Target('at_most', 0)),
    Figure('a simulator alone: registered again, longest', 'alone_time', 's', max, Target('below', LIMIT)),
)
