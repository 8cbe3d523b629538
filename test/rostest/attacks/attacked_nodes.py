"""The nodes that are attacked: started beside the test's master, and seen from outside."""
import signal
import subprocess
import tempfile
from typing import NamedTuple

import rosgraph
import roslib.packages
import rospy

from rostest_support import node_kinds
from rostest_support.common import DEADLINE, Process, registered_names, until
from rostest_support.node_kinds import NodeKind
from rostest_support.tcpros import Peer


class Attacked(NamedTuple):
    """A node of a kind, its process, which may wrap that of the node, and its Peer."""

    kind: NodeKind
    process: Process
    peer: Peer

    def troubles(self):
        """Return what has gone wrong with it so far."""
        return ([] if self.process.runs() else [f'{self.kind.key} has ended:\n{self.process.output()}']) + (
            [f'{self.kind.key} printed a traceback:\n{self.process.output()}']
            if 'Traceback' in self.process.output() else [])


def running(stack, keys):
    """Start the nodes with these keys and those that they need, until an ExitStack ends; return {key: Attacked}.

    All that they have is registered then.
    """
    folder = stack.enter_context(tempfile.TemporaryDirectory())
    node_kinds.make_picture(folder)
    kinds = node_kinds.in_order(keys)
    processes = [stack.enter_context(Process(*_command(kind, folder), stdin=subprocess.PIPE)) for kind in kinds]
    stack.callback(interrupt, processes)
    return {kind.key: Attacked(kind, process, _peer(kind, process)) for kind, process in zip(kinds, processes)}


def interrupt(processes):
    """Send SIGINT to all that run."""
    for process in processes:
        if process.runs():
            process.process.send_signal(signal.SIGINT)


def _command(kind, folder):
    return [roslib.packages.find_node(kind.package, kind.executable)[0], *node_kinds.arguments(kind, folder)]


def _peer(kind, process):
    """Return the Peer of a node, once it has registered all that it has."""
    complete = kind._replace(services=(*kind.services, f'{kind.node}/set_logger_level'))
    until(lambda: not node_kinds.missing(complete, registered_names(kind.node)),
          lambda: f'{kind.key} is up:\n{process.output()}', 3.0 * DEADLINE)
    return Peer(kind.node, rosgraph.Master(rospy.get_name()).lookupNode(kind.node))
