"""Lockstep: wait until the master and all nodes of this machine that follow /clock are idle.

Threading contract: only the thread that publishes /clock uses a Lockstep.
"""
import http.client
import os
import socket
import threading
import time
import xmlrpc.client
from typing import Dict, NamedTuple, Optional, Tuple

import rosgraph
import rospy

from kinematic_core.timing.idle_threads import Gone, ProcessThreads
from kinematic_core.timing.stall_free_timer import ActiveTimer
from process_support import sockets
from rospy_support import rospy_internals

FIRST_PAUSE = 5e-5  # [s] of wall time between the first two checks; it doubles up to LONGEST_PAUSE
LONGEST_PAUSE = 1e-3  # [s]
SETTLING = 0.12  # [s] without work after a registration: the master's threads that notify nodes poll every 0.1 s
WORK = 100_000  # [ns] a thread runs at least this long for a registration; one that polls runs less between two checks
NOBODY = 'the simulator itself, or new connections'  # reported if no node is busy
NODE_TIMEOUT = 1.0  # [s] in which a node must answer a request for its process id
TRIES = 3  # such requests: on a machine that stood still, the timeout passes without an answer


class Snapshot(NamedTuple):
    """The run times {thread id: run time [ns]} of all processes, taken in one check that found no thread running."""

    master: Dict[str, int]  # empty if it cannot be watched
    own: Dict[str, int]
    followers: Tuple[Optional[Dict[str, int]], ...]  # None for one that cannot be watched

    def run_times(self):
        """Return {thread id: run time [ns]} of all processes."""
        processes = (self.master, self.own, *self.followers)
        return {thread: ran for runs in processes for thread, ran in (runs or {}).items()}


class Lockstep:
    """Waits until the followers of a publisher of /clock are idle."""

    def __init__(self, publisher, timeout, step):
        """``timeout`` [s of wall time] is the longest wait; once a node was late, it is ``step`` [s]."""
        self._publisher = publisher
        self._timeout = timeout
        self._step = step
        self._own = ProcessThreads(os.getpid(), without=[threading.get_native_id()])
        self.watch_master()
        self._settled = {}  # {thread: run time [ns]} of the master when all nodes were last idle
        self._connections = ()
        self._followers = {}  # connection: (name, ProcessThreads or None if it cannot be watched)
        self.late = 0  # steps that started although a node was not idle
        self.busy = ''  # names of the nodes that were still busy at the end of the last wait

    def watch_master(self):
        """Find the process of the master, again after a restart."""
        if not rospy.has_param(rospy_internals.LOG_PARAMETER):
            # set the default: until the parameter is set, a node that logs asks the master for it at every line
            rospy.set_param(rospy_internals.LOG_PARAMETER, False)
        self._master = _watch_master()
        self._registrations = _registrations()  # when all nodes were last idle

    def wait(self):
        """Wait until all are idle; return whether they were in time."""
        timer, pause = ActiveTimer(time.monotonic), FIRST_PAUSE
        timeout = self._step if self.busy else self._timeout
        settling = _Settling()
        before = None  # the Snapshot of the last check
        while not rospy.is_shutdown():
            snapshot, now = self._look(), timer.look()
            settling.observe(snapshot, now)
            if _all_idle(before, snapshot) and settling.is_over(now):
                if self._master_settled(snapshot, settling, now):
                    return True
                snapshot = None  # the request has woken the master: check twice more
            before = snapshot
            if now >= timeout:
                self.late += 1
                self.busy = self._busy_names() or self.busy or NOBODY
                return False
            if before is None or pause > FIRST_PAUSE or settling.needed:
                time.sleep(pause)
                pause = min(2.0 * pause, LONGEST_PAUSE)
        return True

    def _look(self):
        """Return a Snapshot; None if a thread is running or a follower has just ended."""
        self._update_followers()
        try:
            master = self._master.runs() if self._master else {}
        except Gone:
            self._master, master = None, {}
        if master is None:
            return None
        own, followers = self._own.runs(), []
        for connection, (name, threads) in self._followers.items():
            try:
                followers.append(threads and threads.runs())
            except Gone:  # the node has ended, and its connection will end soon
                self._followers[connection] = name, None
                return None
            if threads and followers[-1] is None:
                return None
        return None if own is None else Snapshot(master, own, tuple(followers))

    def _master_settled(self, snapshot, settling, now):
        """Return whether the master has notified all nodes of new registrations; all were idle until ``snapshot``.

        To find out, ask the master for its registrations, only once in a wait, because the request wakes its threads.
        """
        if settling.asked or self.busy or not _worked(self._settled, snapshot.master):
            self._settled, self.busy = snapshot.master, ''
            return True
        settling.asked = True
        before, self._registrations = self._registrations, _registrations()
        if before != self._registrations:
            settling.start(now)
        return False

    def _busy_names(self):
        """Return the names of the nodes that are busy now."""
        busy = set()
        for name, threads in self._followers.values():
            try:
                if threads and (threads.runs() is None or threads.runs() != threads.runs()):
                    busy.add(name)
            except Gone:
                pass
        return ', '.join(sorted(busy))

    def _update_followers(self):
        """Update the followers after a change of the connections."""
        connections = tuple(rospy_internals.connections(self._publisher))
        if connections == self._connections:
            return
        for connection in set(self._followers) - set(connections):
            threads = self._followers.pop(connection)[1]
            if threads:
                threads.close()
        for connection in connections:
            if connection not in self._followers:
                self._followers[connection] = (connection.endpoint_id, _watch(connection))
        self._connections = connections


class _Settling:
    """Decides, within one wait, whether the time that the master needs after a registration has passed."""

    def __init__(self):
        self.asked = False  # whether the master was asked for its registrations
        self.needed = 0.0  # [s] for which no node may do any work
        self._since = 0.0  # [s] time of the last work, counted from the start of the wait
        self._ran = None  # {thread: run time [ns]} at the last check

    def start(self, now):
        """Require SETTLING without work from ``now`` [s] on."""
        self.needed, self._since = SETTLING, now

    def observe(self, snapshot, now):
        """Note a Snapshot taken at ``now`` [s]. The short run times of threads that poll do not count as work."""
        if snapshot and self.needed:
            ran = snapshot.run_times()
            if self._ran is None or _worked(self._ran, ran):
                self._since = now
            self._ran = ran

    def is_over(self, now):
        """Return whether no thread has worked for the time that is needed."""
        return now - self._since >= self.needed


def _all_idle(before, after):
    """Return whether no thread has run between two checks, apart from polling of the master; None: one was running."""
    return (before is not None and after is not None and after.own == before.own
            and after.followers == before.followers and not _worked(before.master, after.master))


def _worked(before, after):
    """Return whether a thread has done more than poll."""
    return any(ran - before.get(thread, 0) > WORK for thread, ran in after.items())


def _watch(connection):
    """Return the ProcessThreads of a subscriber; warn and return None if they cannot be watched."""
    name = connection.endpoint_id
    try:
        here, there = connection.socket.getsockname()[0], connection.socket.getpeername()[0]
        if here != there and not there.startswith('127.'):
            raise OSError(f'it runs on another machine ({there})')
        threads = ProcessThreads(sockets.peer_process(connection.socket)
                                 or _pid(rosgraph.Master(rospy.get_name()).lookupNode(name)))
        threads.runs()
        return threads
    except (OSError, AttributeError, xmlrpc.client.Error, rosgraph.MasterException, Gone) as error:
        if not isinstance(error, rosgraph.MasterException):  # no warning: the node has unregistered, it is ending
            rospy.logwarn('Lockstep cannot wait for %s: %s', name, error)
        return None


def _watch_master():
    """Return the ProcessThreads of a master on this machine, else None."""
    try:
        host, _ = rosgraph.network.parse_http_host_and_port(rosgraph.get_master_uri())
        if not rosgraph.network.is_local_address(host):
            return None
        threads = ProcessThreads(_pid(rosgraph.get_master_uri()))
        threads.runs()
        return threads
    except (OSError, ValueError, xmlrpc.client.Error, Gone):
        return None


def _registrations():
    """Return all registrations of the master (getSystemState); None if it does not answer."""
    try:
        return _proxy(rosgraph.get_master_uri()).getSystemState(rospy.get_name())[2]
    except (OSError, xmlrpc.client.Error, http.client.HTTPException):
        return None


class _Transport(xmlrpc.client.Transport):
    """HTTP with a time limit."""

    def make_connection(self, host):
        connection = super().make_connection(host)
        connection.timeout = NODE_TIMEOUT
        return connection


def _pid(uri):
    """Return the process id of the node or master at ``uri``."""
    for left in reversed(range(TRIES)):
        try:
            return _proxy(uri).getPid(rospy.get_name())[2]
        except socket.timeout:
            if not left:
                raise


def _proxy(uri):
    return xmlrpc.client.ServerProxy(uri, transport=_Transport())
