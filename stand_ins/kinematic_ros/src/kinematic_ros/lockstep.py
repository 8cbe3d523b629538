"""What a simulator in lockstep waits for: every node of this machine that follows its /clock, and the master.

Threading contract: one thread, that which publishes /clock, uses a Lockstep.
"""
import os
import threading
import time
import xmlrpc.client

import rosgraph
import rospy

from kinematic_core.rest import Gone, Threads, at_rest

FIRST_LOOK = 5e-5  # [s] wall time between two looks at first; it doubles up to
LATER_LOOKS = 1e-3  # [s]
NODE_TIMEOUT = 1.0  # [s] in which a node must answer what its process is


class Lockstep:
    """Waits until the followers of a publisher of /clock are at rest."""

    def __init__(self, publisher, patience, step):
        """``patience`` [s of wall time]: the longest wait for a step. ``step`` [s]: what a step gets after that."""
        self._publisher, self._patience, self._step = publisher, patience, step
        self._own = Threads(os.getpid(), without=[threading.get_native_id()])
        self._master = None  # Threads, or None until it is known
        self._connections = ()
        self._followers = {}  # connection: (name, Threads, or None where it cannot be watched)
        self.late = 0  # steps that were begun although a node was not at rest
        self.restless = ''  # names of the nodes that were waited for in vain the last time

    def wait(self):
        """Wait for rest; return whether it came in time."""
        begin = time.monotonic()
        patience = self._step if self.restless else self._patience
        look = FIRST_LOOK
        while not self._at_rest():
            if rospy.is_shutdown():
                break
            if time.monotonic() - begin >= patience:
                self.late += 1
                self.restless = self._names() or self.restless or 'the simulator itself'
                return False
            time.sleep(look)
            look = min(2.0 * look, LATER_LOOKS)
        self.restless = ''
        return True

    def _at_rest(self):
        self._update()
        watched = [threads for _, threads in self._followers.values() if threads is not None]
        try:
            return at_rest([self._own, *filter(None, [self._master]), *watched])
        except Gone:  # a node has ended; its connection follows
            for connection, (name, threads) in self._followers.items():
                if threads is not None and not _lives(threads):
                    self._followers[connection] = name, None
            return False

    def _names(self):
        names = []
        for name, threads in self._followers.values():
            try:
                if threads is not None and not at_rest([threads]):
                    names.append(name)
            except Gone:
                pass
        return ', '.join(sorted(set(names)))

    def _update(self):
        """Take in who has come and who has gone."""
        connections = tuple(self._publisher.impl.connections) if self._publisher.impl else ()
        if connections == self._connections:
            return
        if self._master is None:
            self._master = _watch_master()
        for connection in set(self._followers) - set(connections):
            threads = self._followers.pop(connection)[1]
            if threads is not None:
                threads.close()
        for connection in connections:
            if connection not in self._followers:
                self._followers[connection] = (connection.endpoint_id, _watch(connection))
        self._connections = connections


def _lives(threads):
    try:
        threads.runs()
        return True
    except Gone:
        threads.close()
        return False


def _watch(connection):
    """Return the Threads of a subscriber; None, with a warning, when they are out of sight."""
    name = connection.endpoint_id
    try:
        here, there = connection.socket.getsockname()[0], connection.socket.getpeername()[0]
        if here != there and not there.startswith('127.'):
            raise OSError(f'it runs on another machine ({there})')
        threads = Threads(_pid(rosgraph.Master(rospy.get_name()).lookupNode(name)))
        threads.runs()
        return threads
    except (OSError, AttributeError, xmlrpc.client.Error, rosgraph.MasterException, Gone) as error:
        if not isinstance(error, rosgraph.MasterException):  # one that the master does not know any more is leaving
            rospy.logwarn('Lockstep cannot wait for %s: %s', name, error)
        return None


def _watch_master():
    """Return the Threads of a master on this machine, else None."""
    try:
        host, _ = rosgraph.network.parse_http_host_and_port(rosgraph.get_master_uri())
        if not rosgraph.network.is_local_address(host):
            return None
        threads = Threads(_pid(rosgraph.get_master_uri()))
        threads.runs()
        return threads
    except (OSError, ValueError, xmlrpc.client.Error, Gone):
        return None


class _Transport(xmlrpc.client.Transport):
    """HTTP with a time limit."""

    def make_connection(self, host):
        connection = super().make_connection(host)
        connection.timeout = NODE_TIMEOUT
        return connection


def _pid(uri):
    """Return the process id of the node or master at ``uri``."""
    return xmlrpc.client.ServerProxy(uri, transport=_Transport()).getPid(rospy.get_name())[2]
