"""The master and the simulator of a grading, forked from this process, which has imported them already.

Starting Python and importing rospy takes 0.4 s of CPU time; a fork takes some milliseconds. Fork both while this
process has one thread.
"""
import contextlib
import functools
import importlib
import logging
import multiprocessing
import os
import re
import signal
import socket
import sys
import threading
import time

import rosgraph.xmlrpc
import rosmaster.master
import rosmaster.threadpool

from plain_support import processes
from rospy_support import nodes
from sim_ros import lockstep

SIMULATORS = {'turtlesim': 'turtlesim.node', 'robotont': 'robotont_gazebo.node',
              'robots': 'gazebo_ros.server'}  # of an exercise: module with main()
for _module in SIMULATORS.values():
    with contextlib.suppress(ImportError):  # start_simulator says which one is missing
        importlib.import_module(_module)
lockstep.master_poll = 0.0  # of WakingPool; also in the simulators, which are forked from here
POLL = 0.02  # [s] of wall time between two looks at processes, in an attempt
MASTER_POLL = 0.1  # [s] between two checks whether a call has shut the master down
REGISTERED = re.compile(r'\+(PUB|SUB|SERVICE) \[(.*)\] (\S+) ')  # a line of the master's log


class Forked:
    """A process that runs ``run()`` as if started from the command line; it ends with this one at the latest."""

    def __init__(self, name, run, arguments, log):
        """``arguments``: those of the command ``name``; ``log``: the file for its output."""
        self.process = multiprocessing.get_context('fork').Process(
            target=_become, args=(name, run, arguments, log, os.getpid()), name=name)
        self.process.start()
        self.pid = self.process.pid

    def poll(self):
        """Return its exit code (below 0: the signal that ended it), or None while it runs, like Popen."""
        return self.process.exitcode

    def wait(self, timeout):
        """Wait at most ``timeout`` [s] for its end; return its exit code or None."""
        self.process.join(timeout)
        return self.process.exitcode


class WakingPool(rosmaster.threadpool.MarkedThreadPool):
    """Threads of a master that notify nodes at once; rosmaster's poll for that, which delays and costs time."""

    def __init__(self, threads):
        self._changed = threading.Condition()
        super().__init__(threads)

    def queue_task(self, *task):
        """Add a task, and wake a thread for it."""
        with self._changed:
            self._changed.notify_all()
            return super().queue_task(*task)

    def remove_marker(self, marker):
        """Allow the next task of the same node, and wake a thread for it."""
        with self._changed:
            super().remove_marker(marker)
            self._changed.notify_all()

    def get_next_task(self):
        with self._changed:
            while True:
                task = super().get_next_task()
                if task[1] is not None:
                    return task
                self._changed.wait()


def start_master(log, timeout, admits):
    """Fork a ROS master; return (Forked, its URI). Raise TimeoutError if there is none after ``timeout`` [s].

    ``admits(connection)`` decides whether it serves a connection.
    """
    receiver, sender = multiprocessing.Pipe(duplex=False)
    forked = Forked('rosmaster', lambda: _run_master(sender, admits), (), log)
    sender.close()
    with receiver, contextlib.suppress(EOFError):
        if receiver.poll(timeout):
            return forked, receiver.recv()
    raise TimeoutError(f'no ROS master answered within {timeout:g} s; see {log}')


def start_simulator(simulator, arguments, log, *more):
    """Fork the simulator of an exercise; return (Forked, the socket to it). Raise ImportError if it is missing.

    ``more``: what its main() takes after the socket.
    """
    module = importlib.import_module(SIMULATORS[simulator])
    own, its = socket.socketpair()

    def run():
        own.close()
        nodes.run(functools.partial(module.main, its, *more))
    forked = Forked(simulator, run, arguments, log)
    its.close()
    return forked, own


def registrations(log):
    """Return [(kind, name, node)] of all registrations with a master: PUB or SUB of a topic, or SERVICE.

    ``log``: the master's output, which has also what was registered between two polls only.
    """
    with open(log, encoding='utf-8', errors='replace') as file:
        return [match.groups() for match in map(REGISTERED.match, file) if match]


def _run_master(sender, admits):
    logger = logging.getLogger('rosmaster.master')
    logger.setLevel(logging.INFO)
    logger.addHandler(logging.StreamHandler(sys.stdout))
    rosmaster.threadpool.MarkedThreadPool = WakingPool
    rosgraph.xmlrpc.ThreadingXMLRPCServer.verify_request = lambda _server, connection, _address: admits(connection)
    master = rosmaster.master.Master(0)  # any free port
    master.start()
    sender.send(master.uri)
    sender.close()
    while master.ok():
        time.sleep(MASTER_POLL)


def _become(name, run, arguments, log, parent):
    processes.end_with_parent(signal.SIGKILL, parent)
    os.setsid()
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    file = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666)
    for stream in (sys.stdout, sys.stderr):
        os.dup2(file, stream.fileno())
    sys.argv = [name, *arguments]
    run()
