"""Nodes under attack: start them with the nodes that they need, look at them from outside. No rospy."""
import contextlib
import subprocess
import tempfile
import time
from dataclasses import dataclass

from figures import Target
from processes import BenchError, tree
from rostest_support import node_kinds, tcpros
from rostest_support.tcpros import TROUBLE
from session import find_node

COME_UP = 40.0  # [s] until a node has registered everything, on a loaded machine
POLL = 0.05  # [s]
NOTHING = Target('at_most', 0)


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

    def caller(self, name, kind):
        """Return a persistent connection to a service, by absolute name."""
        return tcpros.Caller(tcpros.address(self.master.lookupService(tcpros.CALLER, name)[2]), name, kind)


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
