"""Lets only the grading's own processes command its nodes: the slave API of ROS takes calls from everybody.

``publisherUpdate`` and ``paramUpdate`` come from the master, which also ends a node by ``shutdown`` when another one
takes its name. From a program they change nothing, and it fails. The kernel says who calls (isolation/peers.py). The
rest of the API only tells something, and ``requestTopic`` is how the program subscribes.

Threads: ``allows`` runs in a thread for each call, in this process and in the simulator, which is forked from it.
"""
import contextlib
import os

from course_grader.isolation import peers
from rospy_support.slave_server import SlaveServer

WHAT = {  # the calls that only the grading's own processes may make
    'publisherUpdate': 'change the publishers that it listens to', 'paramUpdate': 'change its parameters',
    'shutdown': 'end it, as rosnode kill does', 'system.multicall': 'make several calls at once'}
LONGEST = 4096  # [bytes] of what a pipe writes at once


class SlaveGuard:
    """Guards the slave API of this process, and of those that are forked from it, until ``close``."""

    def __init__(self, user=None):
        """``user``: the user id of the program, whose calls are its fault; None: every call that is not our own."""
        self._own, self._user = {os.getpid()}, user
        self._told, self._reports = os.pipe()
        self._refused = ''
        for end in (self._told, self._reports):
            os.set_blocking(end, False)
        SlaveServer.allows = staticmethod(self.allows)

    def trust(self, pid):
        """Count a process, such as the master, as part of the grading."""
        self._own.add(pid)

    def allows(self, method, connection):
        """Return whether a call may be made; report one that may not, if it is the program's."""
        if method not in WHAT:
            return True
        peer = peers.of(connection)
        if peer and peer.inode and peers.holds({os.getpid(), *self._own}, peer.inode):
            return True
        if self._user is None or peer and peer.user == self._user:
            with contextlib.suppress(BlockingIOError):  # it is full of reports
                os.write(self._reports, f'{method}\n'.encode())
        return False

    def refused(self):
        """Return what the program tried and may not, as a text, or ''."""
        with contextlib.suppress(BlockingIOError):
            method = os.read(self._told, LONGEST).decode().partition('\n')[0]
            self._refused = self._refused or (
                f'the program called {method} of a node of the grader or the simulator, to {WHAT[method]}: leave the '
                'nodes of others alone')
        return self._refused
