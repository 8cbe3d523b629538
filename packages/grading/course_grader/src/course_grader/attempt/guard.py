"""Attributes what arrives over ROS to processes, as the kernel says (plain_support.sockets): names are free.

In the master, the simulator and the grader:

* Only the grading's own processes command its nodes. ``publisherUpdate`` and ``paramUpdate`` come from the master,
  which also ends a node by ``shutdown`` when another one takes its name. From a program they change nothing, and it
  fails. The rest of the slave API only tells something, and ``requestTopic`` is how the program subscribes.
* Where the program has a user id of its own, connections from and to other users are closed: what they publish,
  answer, register or set is neither for nor against it.
* A connection to a publisher knows whether the program or the grading itself holds its other end.

Threads: all but ``refused`` run in those of connections, in this process and in those that are forked from it.
"""
import contextlib
import os

from course_grader.rules.observation import Problem
from plain_support import sockets
from rospy_support import rospy_internals
from rospy_support.inbound import SocketWatch
from rospy_support.slave_server import SlaveServer

WHAT = {  # the calls that only the grading's own processes may make
    'publisherUpdate': 'change the publishers that it listens to', 'paramUpdate': 'change its parameters',
    'shutdown': 'end it, as rosnode kill does', 'system.multicall': 'make several calls at once'}
LONGEST = 4096  # [bytes] of what a pipe writes at once
GRADING, PROGRAM = 'the grading', 'the program'  # holders of a connection


class Guard:
    """Guards the connections of this process, and of those that are forked from it."""

    def __init__(self, user=None):
        """``user``: the user id of the program; None: every process that is not our own counts as the program's."""
        self._own, self._user = {os.getpid()}, user
        self._told, self._reports = os.pipe()
        self._refused = None
        for end in (self._told, self._reports):
            os.set_blocking(end, False)
        SlaveServer.allows = staticmethod(self.allows)
        SocketWatch.admits = staticmethod(self.admits)
        rospy_internals.attribute_connections(self.holder)

    def trust(self, pid):
        """Count a process, such as the master, as part of the grading."""
        self._own.add(pid)

    def allows(self, method, connection):
        """Return whether a call may be made; report one that may not, if it is the program's."""
        if method not in WHAT:
            return True
        peer = sockets.peer(connection)
        if self._is_own(peer):
            return True
        if self._user is None or peer and peer.user == self._user:
            with contextlib.suppress(BlockingIOError):  # it is full of reports
                os.write(self._reports, f'{method}\n'.encode())
        return False

    def admits(self, connection):
        """Return whether the program or a process of the grading's user holds the other end of a connection."""
        return self._user is None or self._is_known(sockets.peer(connection))

    def holder(self, connection):
        """Return who holds the other end of a connection that this process has made; '': somebody else."""
        peer = sockets.peer(connection)
        if self._is_own(peer):
            return GRADING
        return PROGRAM if self._user is None or self._is_known(peer) else ''

    def _is_own(self, peer):
        return bool(peer and peer.inode) and sockets.holds({os.getpid(), *self._own}, peer.inode)

    def _is_known(self, peer):
        return peer is not None and peer.user in (self._user, os.geteuid())

    def refused(self):
        """Return the Problem of a program that tried what it may not, or None."""
        with contextlib.suppress(BlockingIOError):
            method = os.read(self._told, LONGEST).decode().partition('\n')[0]
            self._refused = self._refused or Problem(
                f'the program called {method} of a node of the grader or the simulator, to {WHAT[method]}: leave the '
                'nodes of others alone')
        return self._refused


def of_the_grading(message):
    """Return whether a process of the grading holds the connection on which a message has arrived."""
    return rospy_internals.holder(message) == GRADING


def of_the_program(message):
    """Return whether the program holds the connection on which a message has arrived."""
    return rospy_internals.holder(message) == PROGRAM
