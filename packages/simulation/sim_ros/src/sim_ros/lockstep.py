"""Lockstep: wait until the master and all nodes of this machine that follow /clock are idle.

Threading contract: only the thread that publishes /clock uses a Lockstep.
"""
from __future__ import annotations

import contextlib
import http.client
import os
import socket
import threading
import time
import xmlrpc.client
from typing import Any, Dict

import rosgraph
import rospy

from kinematic_core.timing.idle_threads import Gone, Machine, ProcessThreads
from kinematic_core.timing.stall_free_timer import ActiveTimer
from plain_support import sockets
from rospy_support import rospy_internals
from rospy_support.limited_transport import LimitedTransport

FIRST_PAUSE = 5e-5  # [s] of wall time between two checks; before the first one, as long as the nodes mostly take
ENOUGH = 2  # pauses of a wait: one in which the nodes finish, and one in which nothing happens
SHORTER, LONGER = 0.95, 1.1  # the next first pause after a wait that took so few, and after a longer one
GROWTH = 1.25  # of the next pause, up to MAX_PAUSE
MAX_PAUSE = 1e-3  # [s]
STARVED = 10.0  # times the longest wait, for nodes that have run for less than WORKED of it: they wait for a core
WORKED, NOTICED = 0.5, 0.05  # the share; [s] of the wait after which it is counted, as nearly all are shorter
JOINING = 0.12  # [s] without work after the registration of a new node, whose init_node polls every 0.1 s
SETTLING = 0.02  # [s] without work after another registration, once the master has notified the nodes of it
WORK = 200_000  # [ns] a process runs longer for a registration, 450 us or more; one that polls runs for 50 to 150 us
MOST_SETTLING = 10.0  # times JOINING or SETTLING until it is over all the same: on a slower machine polls run longer
NOBODY = 'the simulator itself, or new connections'  # reported if no node is busy
NODE_TIMEOUT = 1.0  # [s] in which a node must answer a request for its process id
TRIES = 3  # such requests, because a machine that stood still times out without an answer

Runs = Dict[ProcessThreads, int]  # run time of each process [ns]

master_poll = 0.1  # [s] period of the master's threads that notify nodes; set it if you start a faster master


class Lockstep:
    """Waits until the followers of a publisher of /clock are idle."""

    def __init__(self, publisher: rospy.Publisher, timeout: float, step: float, parent: int | None = None) -> None:
        """``timeout`` [s] is the longest wait; once a node was late, it is ``step`` [s].

        On a loaded machine, where the nodes wait for a core instead, it is up to STARVED times as long. ``parent``: the
        number of a process that is waited for, too, although it does not follow /clock.
        """
        self._publisher = publisher
        self._timeout = timeout
        self._step = step
        self._machine = Machine()
        _sleep_exactly()
        self._own = ProcessThreads(os.getpid(), without=[threading.get_native_id()])
        self._parent = None if parent is None else ProcessThreads(parent)
        self._followers: dict[Any, tuple[str, ProcessThreads | None]] = {}  # of a connection; None: cannot be watched
        self.watch_master()
        self._settled: Runs = {}  # {master: run time [ns]} when all nodes were last idle
        self._first_pause = FIRST_PAUSE  # [s]
        self._connections: tuple[Any, ...] = ()
        self.late = 0  # steps that started although a node was not idle
        self.starved = False  # whether the last of them did so because the nodes got no core
        self.busy = ''  # names of the nodes that were still busy at the end of the last wait

    def watch_master(self) -> None:
        """Find the process of the master, again after a restart."""
        if not rospy.has_param(rospy_internals.LOG_PARAMETER):
            # set the default: until the parameter is set, a node that logs asks the master for it at every line
            rospy.set_param(rospy_internals.LOG_PARAMETER, False)
        self._master = _watch_master()
        self._update_processes()
        self._registrations = _registrations()  # when all nodes were last idle

    def wait(self) -> bool:
        """Wait until all are idle; return whether they were in time."""
        timer, pause, pauses = ActiveTimer(time.monotonic), self._first_pause, 0
        timeout, longest = (self._step,) * 2 if self.busy else (self._timeout, STARVED * self._timeout)
        settling = _Settling()
        ran: Runs | None = None
        began: Runs | None = None
        self.starved = False
        while not rospy.is_shutdown():
            self._update_followers()
            before, ran, runs = ran, self._ran(), None
            if self._same(before, ran) or before is None and not self._followers:  # spare checks of those that work
                runs = self._run_times(ran)
            now = timer.elapsed()
            settling.observe(runs, now)
            # check twice on a busy machine: the kernel may not have delivered yet what a node has sent
            if runs is not None and settling.is_over(now) and (self._same(before, runs) or not self._machine.is_busy()):
                if self._master_settled(runs, settling, now):
                    self._adapt(pauses)
                    return True
                ran = None  # the request has woken the master
            if began is None and now >= NOTICED:
                began = self._ran()
            if now >= timeout:
                self.starved = timeout < longest and not (began and self._worked_since(began) >= WORKED * timeout)
            if now >= (longest if self.starved else timeout):
                self.late += 1
                self.busy = self._busy_names() or self.busy or NOBODY
                return False
            time.sleep(pause)
            pauses += 1
            pause = FIRST_PAUSE if pauses == 1 else min(GROWTH * pause, MAX_PAUSE)
        return True

    def _adapt(self, pauses: int) -> None:
        """Choose the first pause of the next wait so that most nodes have finished after it."""
        if pauses:
            self._first_pause *= LONGER if pauses > ENOUGH else SHORTER
            self._first_pause = min(max(self._first_pause, FIRST_PAUSE), MAX_PAUSE)

    def _ran(self) -> Runs:
        """Return {process: run time [ns]} of all that are waited for, except those that have ended."""
        found = {}
        for process in self._processes:
            try:  # contextlib.suppress would take as long as the rest
                found[process] = process.ran()
            except Gone:
                pass
        return found

    def _worked_since(self, began: Runs) -> float:
        """Return for how long [s] the busiest process has run since ``began``, {process: run time [ns]}.

        One that has joined since then does not count: most of its time went into its imports.
        """
        return max((ran - began.get(process, ran) for process, ran in self._ran().items()), default=0) / 1e9

    def _update_processes(self) -> None:
        """List the processes that are waited for: the followers, the simulator itself, its parent, and the master."""
        followers = [threads for _, threads in self._followers.values()]
        self._processes = [*filter(None, (*followers, self._own, self._parent, self._master))]

    def _run_times(self, before: Runs) -> Runs | None:
        """Return {process: run time [ns]} if all are idle; None if one is busy, has just ended or run since ``before``.
        """
        try:
            own = self._own, self._parent, self._master  # which share no locks
            for process in self._processes:
                if not (process.sleeps(before.get(process, -1)) if process in own else process.sleeps()):
                    return None
            after = {process: process.ran() for process in self._processes}
        except Gone:
            self._forget_ended()
            return None
        return after if self._same(before, after) else None

    def _same(self, before: Runs | None, after: Runs) -> bool:
        """Return whether no process has run between two {process: run time [ns]}; the master polls."""
        return before is not None and all(ran - before.get(process, 0) <= (WORK if process is self._master else 0)
                                          for process, ran in after.items())

    def _forget_ended(self) -> None:
        """Stop watching processes that have ended; the connections of such nodes end soon."""
        self._followers = {connection: (name, None if threads is None or _has_ended(threads) else threads)
                           for connection, (name, threads) in self._followers.items()}
        if self._master and _has_ended(self._master):
            self._master = None
        self._update_processes()

    def _master_settled(self, runs: Runs, settling: _Settling, now: float) -> bool:
        """Return whether the master has notified all nodes of new registrations; all were idle with ``runs``.

        To find out, ask the master for its registrations, only once in a wait, because the request wakes its threads.
        """
        ran = {process: ran for process, ran in runs.items() if process is self._master}
        if settling.asked or self.busy or not _worked(self._settled, ran):
            self._settled, self.busy = ran, ''
            return True
        settling.asked = True
        before, self._registrations = self._registrations, _registrations()
        if before != self._registrations:
            new = _nodes(self._registrations) - _nodes(before)
            settling.start(now, max(JOINING if new else 0.0, master_poll + SETTLING))
        return False

    def _busy_names(self) -> str:
        """Return the names of the nodes that are busy now."""
        return ', '.join(sorted({name for name, threads in self._followers.values() if threads and _is_busy(threads)}))

    def _update_followers(self) -> None:
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
        self._update_processes()


class _Settling:
    """Decides, within one wait, whether the time that the master needs after a registration has passed."""

    def __init__(self) -> None:
        self.asked = False  # whether the master was asked for its registrations
        self.needed = 0.0  # [s] for which no node may do any work
        self._since = self._end = 0.0  # [s] time of the last work, and until when it counts, from the start of the wait
        self._runs: Runs | None = None  # {process: run time [ns]} at the last check

    def start(self, now: float, needed: float) -> None:
        """Require ``needed`` [s] without work from ``now`` [s] on."""
        self.needed, self._since, self._end = needed, now, now + MOST_SETTLING * needed

    def observe(self, runs: Runs | None, now: float) -> None:
        """Note ``runs``, {process: run time [ns]} at ``now`` [s] or None. The short run times of polls are no work."""
        if runs and self.needed:
            if self._runs is None or _worked(self._runs, runs):
                self._since = now
            self._runs = runs

    def is_over(self, now: float) -> bool:
        """Return whether no process has worked for the time that is needed."""
        return now - self._since >= self.needed or now >= self._end


def _worked(before: Runs, after: Runs) -> bool:
    """Return whether a process has done more than poll between two {process: run time [ns]}."""
    return any(ran - before.get(process, 0) > WORK for process, ran in after.items())


def _sleep_exactly() -> None:
    """Let this thread wake on time: Linux may add 50 us to each sleep, as long as the first pause."""
    with contextlib.suppress(OSError), open(f'/proc/{threading.get_native_id()}/timerslack_ns', 'w',
                                            encoding='ascii') as file:
        file.write('1')


def _is_busy(threads: ProcessThreads) -> bool:
    """Return whether a process works now."""
    try:
        before = threads.ran()
        return not threads.sleeps() or threads.ran() != before
    except Gone:
        return False


def _has_ended(threads: ProcessThreads) -> bool:
    try:
        threads.ran()
        threads.sleeps()
    except Gone:
        return True
    return False


def _watch(connection: Any) -> ProcessThreads | None:
    """Return the ProcessThreads of a subscriber; warn and return None if they cannot be watched."""
    name = connection.endpoint_id
    try:
        here, there = connection.socket.getsockname()[0], connection.socket.getpeername()[0]
        if here != there and not there.startswith('127.'):
            raise OSError(f'it runs on another machine ({there})')
        threads = ProcessThreads(sockets.peer_process(connection.socket)
                                 or _pid(rosgraph.Master(rospy.get_name()).lookupNode(name)))
        threads.sleeps()
        return threads
    except (OSError, AttributeError, xmlrpc.client.Error, rosgraph.MasterException, Gone) as error:
        if not isinstance(error, rosgraph.MasterException):  # no warning: the node has unregistered, it is ending
            rospy.logwarn('Lockstep cannot wait for %s: %s', name, error)
        return None


def _watch_master() -> ProcessThreads | None:
    """Return the ProcessThreads of a master on this machine, else None."""
    try:
        host, _ = rosgraph.network.parse_http_host_and_port(rosgraph.get_master_uri())
        if not rosgraph.network.is_local_address(host):
            return None
        threads = ProcessThreads(_pid(rosgraph.get_master_uri()))
        threads.sleeps()
        return threads
    except (OSError, ValueError, xmlrpc.client.Error, Gone):
        return None


def _registrations() -> Any:
    """Return all registrations of the master (getSystemState); None if it does not answer, or with more than 20 MB."""
    try:
        return _proxy(rosgraph.get_master_uri()).getSystemState(rospy.get_name())[2]
    except (OSError, ValueError, xmlrpc.client.Error, http.client.HTTPException):  # ValueError: too long
        return None


def _nodes(registrations: Any) -> set[str]:
    """Return the names of the nodes in registrations; none if the master did not answer."""
    return {node for kind in registrations or () for _, nodes in kind for node in nodes}


def _pid(uri: str) -> int:
    """Return the process id of the node or master at ``uri``."""
    for _ in range(TRIES - 1):
        with contextlib.suppress(socket.timeout):
            return _proxy(uri).getPid(rospy.get_name())[2]
    return _proxy(uri).getPid(rospy.get_name())[2]


def _proxy(uri: str) -> Any:
    return xmlrpc.client.ServerProxy(uri, transport=LimitedTransport(NODE_TIMEOUT))
