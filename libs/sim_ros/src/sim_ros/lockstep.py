"""What a simulator in lockstep waits for: every node of this machine that follows its /clock, and the master.

Threading contract: one thread, that which publishes /clock, uses a Lockstep.
"""
import http.client
import os
import socket
import threading
import time
import xmlrpc.client

import rosgraph
import rospy

from kinematic_core.timing.idle_threads import Gone, ProcessThreads
from kinematic_core.timing.stall_free_timer import ActiveTimer
from rospy_support import rospy_internals

FIRST_PAUSE = 5e-5  # [s] of wall time between two looks at first; it doubles up to
LONGEST_PAUSE = 1e-3  # [s]
SETTLING = 0.12  # [s] of rest asked for after a registration: the master's threads that tell others look every 0.1 s
WORK = 100_000  # [ns] that a thread runs at least for a registration; threads that poll run less between two looks
LOG_PARAMETER = '/rosout_disable_topics_generation'  # rospy asks the master for it at every line that it logs
NOBODY = 'the simulator itself, or connections that are being made'  # where no node is busy
NODE_TIMEOUT = 1.0  # [s] in which a node must answer what its process is
TRIES = 3  # to ask it: a machine that stands still lets that time pass


class Lockstep:
    """Waits until the followers of a publisher of /clock are at rest."""

    def __init__(self, publisher, patience, step):
        """``patience`` [s of wall time]: the longest wait for a step. ``step`` [s]: what a step gets after that."""
        self._publisher, self._patience, self._step = publisher, patience, step
        self._own = ProcessThreads(os.getpid(), without=[threading.get_native_id()])
        self.watch_master()
        self._settled = {}  # how long [ns] each thread of the master had run at the last rest
        self._connections = ()
        self._followers = {}  # connection: (name, ProcessThreads, or None where it cannot be watched)
        self.late = 0  # steps that were begun although a node was not at rest
        self.restless = ''  # names of the nodes that were waited for in vain the last time

    def watch_master(self):
        """Look for the master; again when it was started anew."""
        if not rospy.has_param(LOG_PARAMETER):
            rospy.set_param(LOG_PARAMETER, False)  # its default; a node that logs asks for it until it is set
        self._master, self._books = _watch_master(), _books()  # and what was registered at the last rest

    def wait(self):
        """Wait for rest; return whether it came in time."""
        since, waiting = 0.0, ActiveTimer(time.monotonic)
        patience = self._step if self.restless else self._patience
        pause, seen, before, needed, asked = FIRST_PAUSE, None, None, 0.0, False
        while not rospy.is_shutdown():
            looked, now = self._look(), waiting.look()
            if looked and needed:  # who polls in wall time wakes up now and then, for nothing
                if before is None or _worked(_flat(before), _flat(looked)):
                    since = now
                before = looked
            at_rest = looked and seen and looked[1:] == seen[1:] and not _worked(seen[0], looked[0])
            if at_rest and now - since >= needed:
                if asked or self.restless or not _worked(self._settled, looked[0]):
                    self._settled, self.restless = looked[0], ''
                    return True
                asked, looked = True, None
                if self._registered():
                    needed, since = SETTLING, now
            seen = looked
            if now >= patience:
                self.late += 1
                self.restless = self._names() or self.restless or NOBODY
                return False
            if seen is None or pause > FIRST_PAUSE or needed:
                time.sleep(pause)
                pause = min(2.0 * pause, LONGEST_PAUSE)
        return True

    def _look(self):
        """Return how long each thread has run, the master's first; None when one runs."""
        self._update()
        try:
            master = self._master.runs() if self._master else {}
        except Gone:
            self._master, master = None, {}
        if master is None:
            return None
        looked = [master, self._own.runs()]
        for connection, (name, threads) in self._followers.items():
            try:
                looked.append(threads and threads.runs())
            except Gone:  # the node has ended; its connection follows
                self._followers[connection] = name, None
                return None
            if threads and looked[-1] is None:
                return None
        return None if looked[1] is None else looked

    def _registered(self):
        """Return whether anything was registered or unregistered since the last rest."""
        before, self._books = self._books, _books()
        return before != self._books

    def _names(self):
        """Return the names of the nodes that are busy just now."""
        busy = set()
        for name, threads in self._followers.values():
            try:
                if threads and (threads.runs() is None or threads.runs() != threads.runs()):
                    busy.add(name)
            except Gone:
                pass
        return ', '.join(sorted(busy))

    def _update(self):
        """Take in who has come and who has gone."""
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


def _flat(looked):
    """Return {thread: how long it has run [ns]} of all processes in a look."""
    return {thread: ran for runs in looked for thread, ran in (runs or {}).items()}


def _worked(before, after):
    """Return whether a thread has done more than to look for work."""
    return any(ran - before.get(thread, 0) > WORK for thread, ran in after.items())


def _watch(connection):
    """Return the ProcessThreads of a subscriber; None, with a warning, when they are out of sight."""
    name = connection.endpoint_id
    try:
        here, there = connection.socket.getsockname()[0], connection.socket.getpeername()[0]
        if here != there and not there.startswith('127.'):
            raise OSError(f'it runs on another machine ({there})')
        threads = ProcessThreads(_pid(rosgraph.Master(rospy.get_name()).lookupNode(name)))
        threads.runs()
        return threads
    except (OSError, AttributeError, xmlrpc.client.Error, rosgraph.MasterException, Gone) as error:
        if not isinstance(error, rosgraph.MasterException):  # one that the master does not know any more is leaving
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


def _books():
    """Return what is registered with the master, or None."""
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
