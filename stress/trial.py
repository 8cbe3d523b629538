"""Nodes under attack: start them with the nodes that they need, watch them from outside, count losses. No rospy."""
import contextlib
import socket
import subprocess
import tempfile
import time
from dataclasses import dataclass

from figures import Figure, Target
from processes import BenchError, peak_memory, tree
from rostest_support import node_kinds, tcpros
from rostest_support.tcpros import TROUBLE
from session import find_node

COME_UP = 40.0  # [s] until a node has registered everything, on a loaded machine
POLL = 0.05  # [s]
SETTLED = 20.0  # [s] within which a node has released what its clients left
NOTHING = Target('at_most', 0)
SPARE = 8  # descriptors and threads that may come and go: the node's own calls to master and clients


def until(condition, what):
    """Poll until ``condition()`` is true and return its value; raise BenchError after COME_UP."""
    end = time.monotonic() + COME_UP
    while True:
        try:
            value = condition()
        except TROUBLE:
            value = None
        if value:
            return value
        if time.monotonic() > end:
            raise BenchError(f'not within {COME_UP:g} s: {what}')
        time.sleep(POLL)


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


class Node:
    """A running node. ``kind``: a NodeKind; ``child``: its process, which may wrap that of the node."""

    def __init__(self, kind, child, subject):
        self.kind, self.child = kind, child
        self.master = tcpros.api(subject.uri)
        self.peer = None  # a tcpros.Peer, once it is registered

    @property
    def pid(self):
        return self.peer.pid

    def await_registered(self):
        """Wait until the master knows all its names."""
        def there():
            self.child.require_alive()
            if node_kinds.missing(self.kind, self.registered()):
                return False
            self.peer = tcpros.Peer(self.kind.node, self.master.lookupNode(tcpros.CALLER, self.kind.node)[2])
            # not one of the same name that was killed
            return self.pid in {process.pid for process in tree(self.child.pid)}
        until(there, f'{self.kind.key} has registered {self.kind.published + self.kind.services}')

    def registered(self):
        """Return the names (published, subscribed, services) that the master knows of it, sets."""
        state = self.master.getSystemState(tcpros.CALLER)[2]
        return tuple({name for name, nodes in kind if self.kind.node in nodes} for kind in state)

    def answers(self):
        """Return whether a new subscriber and a service call are answered."""
        try:
            return bool(self.peer.answers())
        except TROUBLE:
            return False

    def caller(self, name, kind, timeout=tcpros.DEADLINE):
        """Return a persistent connection to a service, by absolute name."""
        return tcpros.Caller(tcpros.address(self.master.lookupService(tcpros.CALLER, name)[2]), name, kind, timeout)

    def peak_memory(self):
        """Return the peak resident memory [MB]."""
        return peak_memory(self.pid) / 1e6


@contextlib.contextmanager
def running(subject, *keys):
    """Yield {key: Node} of the kinds with these keys and of those they need, all registered; end them afterwards."""
    folder = node_kinds.make_picture(tempfile.mkdtemp(dir=subject.folder))
    with contextlib.ExitStack() as stack:
        nodes = {}
        for kind in node_kinds.in_order(keys):
            command = [*find_node(kind.package, kind.executable), *node_kinds.arguments(kind, folder)]
            child = stack.enter_context(subject.start(f'{kind.key}', command, stdin=subprocess.PIPE))
            nodes[kind.key] = Node(kind, child, subject)
        for node in nodes.values():
            node.await_registered()
        yield nodes


class Trial:
    """Watches a Node through an attack."""

    def __init__(self, node):
        self.node = node
        self.inputs = self.hung = 0
        node.answers()  # the node now has everything open that a first listener needs
        self._descriptors, self._threads = node.peer.descriptors(), node.peer.threads()

    def answered(self, call):
        """Count an input; ``call()`` sends it and waits. Return its value, None without an answer."""
        self.inputs += 1
        try:
            return call()
        except socket.timeout:
            self.hung += 1
        except TROUBLE:
            pass  # closed, or answered with an error: an answer, too
        return None

    def samples(self, name):
        """End the attack; return {key: samples} of all that was lost."""
        time.sleep(POLL)
        found = {'inputs': self.inputs, 'hung': self.hung, 'ended': int(not self.node.child.runs())}
        if not found['ended']:
            found['deaf'] = int(not self.node.answers())
            found['descriptors'], found['threads'] = self._left()
        return {f'{name}_{key}': [value] for key, value in found.items()}

    def _left(self):
        """Return how many more descriptors and threads there are than before; wait up to SETTLED for few."""
        end = time.monotonic() + SETTLED
        while True:
            left = self.node.peer.descriptors() - self._descriptors, self.node.peer.threads() - self._threads
            if max(left) <= SPARE or time.monotonic() > end:
                return left
            time.sleep(POLL)


def losses(name, words):
    """Return the figures of a Trial's samples."""
    yield Figure(f'{words}: inputs', f'{name}_inputs', '', sum)
    yield Figure(f'{words}: never answered', f'{name}_hung', '', sum, NOTHING)
    yield Figure(f'{words}: nodes ended', f'{name}_ended', '', sum, NOTHING)
    yield Figure(f'{words}: deaf afterwards', f'{name}_deaf', '', sum, NOTHING)
    yield Figure(f'{words}: descriptors left', f'{name}_descriptors', '', max, Target('at_most', SPARE))
    yield Figure(f'{words}: threads left', f'{name}_threads', '', max, Target('at_most', SPARE))
