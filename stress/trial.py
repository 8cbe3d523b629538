"""One attack on one node: what was sent, what was lost, what it left behind, and the figures of these."""

import time
from dataclasses import dataclass

from nav_msgs.msg import Odometry
from roscpp.srv import GetLoggers
from turtlesim.msg import Pose

import tcpros
from figures import Figure, Target
from under_test import TROUBLE

NOTHING = Target('at_most', 0)
SETTLED = 20.0  # [s] within which a node has let go of what its clients left
SPARE = 8  # descriptors and threads that may come and go: the node's own calls to master and clients
POLL = 0.25  # [s]
PEN = 179, 184, 255, 3, 0  # turtle1's at the start


@dataclass(frozen=True)
class Attack:
    """run(subject, scale, rng) -> {figure key: samples}; peer: whether another turtlesim_node can take part."""

    run: object
    about: str
    peer: bool = True


@dataclass(frozen=True)
class Scale:
    """How much of everything. ``factor``: 1 is the full form; ``small``: for the tests, on a loaded machine."""

    factor: float = 1.0
    small: bool = False

    def count(self, full, small):
        """Return ``full`` times the factor, at least 1, or ``small``."""
        return small if self.small else max(1, round(full * self.factor))

    def seconds(self, full, small):
        """Return how long [s]."""
        return small if self.small else full * self.factor


class Trial:
    """Watches a Node through an attack."""

    def __init__(self, node):
        self.node = node
        self.inputs = self.hung = 0
        self._simulator = node.kind.key in ('turtlesim', 'robotont')
        self._state = node.state() if self._simulator else {}
        listen(node)  # what a first listener makes the node open is there from now on
        self._descriptors, self._threads = node.descriptors(), node.threads()

    def answered(self, call):
        """Count an input; ``call()`` sends it and waits. Return its value, None without an answer."""
        self.inputs += 1
        try:
            return call()
        except tcpros.NeverAnswered:
            self.hung += 1
        except TROUBLE:
            pass  # closed, or answered with an error: an answer, too
        return None

    def samples(self, name):
        """End the attack; return {key: samples} of all that was lost."""
        found = {'inputs': self.inputs, 'hung': self.hung, 'ended': 0 if self._lives() else 1}
        if not found['ended']:
            found['deaf'] = deaf(self.node)
        if not found['ended'] and not found['deaf']:
            found.update(self._left())
            if self._simulator:
                found['changed'] = self._changed()
        return {f'{name}_{key}': [value] for key, value in found.items()}

    def _lives(self):
        time.sleep(POLL)
        return self.node.runs()

    def _left(self):
        """Return how many more descriptors and threads there are than before; wait up to SETTLED for few."""
        end = time.monotonic() + SETTLED
        while True:
            left = self.node.descriptors() - self._descriptors, self.node.threads() - self._threads
            if max(left) <= SPARE or time.monotonic() > end:
                return {'descriptors': left[0], 'threads': left[1]}
            time.sleep(POLL)

    def _changed(self):
        try:
            now = self.node.state()
        except TROUBLE:
            return len(self._state)
        return sum(now.get(key) != value for key, value in self._state.items()) + len(set(now) - set(self._state))


def deaf(node):
    """Return how many of two, a service call and a new subscriber, a node did not answer."""
    return sum(not heard for heard in (answers(node), listen(node)))


def answers(node, timeout=tcpros.DEADLINE):
    """Return whether a call that changes nothing is answered."""
    try:
        if node.kind.key == 'turtlesim':
            node.call('/turtle1/set_pen', *PEN, timeout=timeout)
        else:
            caller = node.caller(f'{node.kind.node}/get_loggers', GetLoggers, timeout)
            try:
                caller.call()
            finally:
                caller.close()
        return True
    except TROUBLE:
        return False


def listen(node, timeout=tcpros.DEADLINE):
    """Return whether a new subscriber gets a message of a simulator, or a header from another node."""
    topics = {'turtlesim': ('/turtle1/pose', Pose, True), 'robotont': ('/odom', Odometry, True)}
    if node.kind.key not in topics:
        return True  # its service was asked: the same port and thread
    topic, kind, publishes = topics[node.kind.key]
    try:
        connection = tcpros.subscribe(node.uri, topic, kind, timeout)
        try:
            return not publishes or bool(tcpros.receive_frame(connection))
        finally:
            connection.close()
    except TROUBLE:
        return False


def losses(name, words, changed=True):
    """Return the figures of a Trial's samples."""
    yield Figure(f'{words}: inputs', f'{name}_inputs', '', sum)
    yield Figure(f'{words}: never answered', f'{name}_hung', '', sum, NOTHING)
    yield Figure(f'{words}: nodes ended', f'{name}_ended', '', sum, NOTHING)
    yield Figure(f'{words}: deaf afterwards', f'{name}_deaf', '', sum, NOTHING)
    if changed:
        yield Figure(f'{words}: poses or canvas changed', f'{name}_changed', '', sum, NOTHING)
    yield Figure(f'{words}: descriptors left', f'{name}_descriptors', '', max, Target('at_most', SPARE))
    yield Figure(f'{words}: threads left', f'{name}_threads', '', max, Target('at_most', SPARE))
