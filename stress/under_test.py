"""Nodes under attack: starts them with what they need, watches them in /proc, asks for their state. No rospy."""

import contextlib
import hashlib
import os
import struct
import subprocess
import sys
import tempfile
import threading
import time
import xmlrpc.client
from http.client import HTTPException

import psutil
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from std_msgs.msg import String
from std_srvs.srv import Empty, Trigger
from turtlesim.msg import Pose
from turtlesim.srv import Kill, SetPen, Spawn, TeleportAbsolute, TeleportRelative

import tcpros
from figures import OURS, median_rate
from processes import BenchError, peak_memory, tree
from rostest_support import node_kinds
from session import find_node

COME_UP = 40.0  # [s] until a node has registered everything, on a loaded machine
POLL = 0.05  # [s]
POLITE = 2.0  # [s] for an answer while it starts
SPAN = 60  # poses over which a rate is taken
POSE = struct.Struct('<5f')
TEXT_LENGTH = struct.Struct('<I')
ODOMETRY_POSE = struct.Struct('<7d')
TROUBLE = (OSError, xmlrpc.client.Error, HTTPException, tcpros.NeverAnswered, tcpros.Closed)
SERVICES = {'clear': Empty, 'reset': Empty, 'spawn': Spawn, 'kill': Kill, 'set_pen': SetPen,
            'teleport_absolute': TeleportAbsolute, 'teleport_relative': TeleportRelative, 'snapshot': Trigger,
            'pause': Trigger, 'resume': Trigger}
MOTION = {'turtlesim': ('/turtle1/cmd_vel', Twist), 'robotont': ('/cmd_vel', Twist)}
FRESH = {'turtlesim': ('/turtle1/pose', Pose), 'robotont': ('/robotont_gazebo/ground_truth', Odometry)}


def tell(text):
    """Print the progress on stderr; stdout is for the table."""
    print(text, file=sys.stderr, flush=True)


def until(condition, what, deadline=COME_UP, poll=POLL):
    """Poll until ``condition()`` is true and return its value; raise BenchError after ``deadline`` [s]."""
    end = time.monotonic() + deadline
    while True:
        try:
            value = condition()
        except TROUBLE:
            value = None
        if value:
            return value
        if time.monotonic() > end:
            raise BenchError(f'not within {deadline:g} s: {what}')
        time.sleep(poll)


class Node:
    """A running node. ``kind``: a NodeKind; ``child``: its process, which may wrap that of the node."""

    def __init__(self, kind, child, subject):
        self.kind, self.child, self.subject = kind, child, subject
        self.uri = self.pid = None
        self._of_thread = threading.local()

    @property
    def master(self):
        """Return the master's API, with a connection for each thread."""
        if not hasattr(self._of_thread, 'master'):
            self._of_thread.master = tcpros.api(self.subject.uri)
        return self._of_thread.master

    def await_registered(self, deadline=COME_UP):
        """Wait until the master knows all its names."""
        def there():
            self.child.require_alive()
            if self.missing():
                return False
            self.uri = self.master.lookupNode(tcpros.CALLER, self.kind.node)[2]
            self.pid = tcpros.api(self.uri, POLITE).getPid(tcpros.CALLER)[2]
            # not one of the same name that was killed
            return self.pid in {process.pid for process in tree(self.child.pid)}
        until(there, f'{self.kind.key} has registered {self.kind.published + self.kind.services}', deadline)

    def registered(self):
        """Return the names (published, subscribed, services) that the master knows of it, sets."""
        state = self.master.getSystemState(tcpros.CALLER)[2]
        return tuple({name for name, nodes in kind if self.kind.node in nodes} for kind in state)

    def missing(self):
        """Return the names that it should have registered but has not; for a peer only those of turtlesim."""
        left = node_kinds.missing(self.kind, self.registered())
        if self.subject.side == OURS:
            return left
        return [name for name in left if not name.startswith(self.kind.node + '/')]

    def runs(self):
        """Return whether its process runs."""
        return self.child.runs()

    def descriptors(self):
        """Return how many descriptors it has open."""
        return psutil.Process(self.pid).num_fds()

    def threads(self):
        """Return how many threads it has."""
        return psutil.Process(self.pid).num_threads()

    def memory(self):
        """Return the resident memory [MB]."""
        return psutil.Process(self.pid).memory_info().rss / 1e6

    def peak_memory(self):
        """Return the peak resident memory [MB]."""
        return peak_memory(self.pid) / 1e6

    def service_place(self, name):
        """Return the (host, port) of a service."""
        code, status, uri = self.master.lookupService(tcpros.CALLER, name)
        if code != 1:
            raise tcpros.Closed(status)
        return tcpros.address(uri)

    def caller(self, name, kind=None, timeout=tcpros.DEADLINE):
        """Return a persistent connection to one of its services, by absolute name."""
        kind = kind or SERVICES[name.rpartition('/')[2]]
        return tcpros.Caller(self.service_place(name), name, kind, timeout)

    def call(self, name, *values, timeout=tcpros.DEADLINE):
        """Call a service once; return (accepted, bytes)."""
        kind = SERVICES[name.rpartition('/')[2]]
        caller = self.caller(name, timeout=timeout)
        try:
            return caller.call(serialized(kind._request_class(*values)))
        finally:
            caller.close()

    def receiver(self, topic=None, kind=None):
        """Return a Receiver of a topic, by default of the simulator's poses."""
        topic, kind = (topic, kind) if topic else FRESH[self.kind.key]
        return tcpros.Receiver(tcpros.subscribe(self.uri, topic, kind))

    def message(self, topic, kind):
        """Return the bytes of a latched message, or of the next one that is published."""
        connection = tcpros.subscribe(self.uri, topic, kind)
        try:
            return tcpros.receive_frame(connection)
        finally:
            connection.close()

    def tcpros_place(self):
        """Return the (host, port) for connections of services and subscribers."""
        published = self.kind.published
        if self.kind.services:
            return self.service_place(self.kind.services[0])
        topics = published or ('/rosout',)
        return tuple(tcpros.api(self.uri).requestTopic(tcpros.CALLER, topics[0], [['TCPROS']])[2][1:3])

    def state(self):
        """Return all that only a legal request may change: poses and image, or the robot's pose and world."""
        if self.kind.key == 'robotont':
            return {'pose': ground_truth(self.message('/robotont_gazebo/ground_truth', Odometry)),
                    'world': self.message('/robotont_gazebo/world', String)}
        topics = sorted(topic for topic in self.registered()[0] if topic.endswith('/pose'))
        found = {topic: POSE.unpack(self.message(topic, Pose)) for topic in topics}
        if self.subject.side == OURS:
            found['canvas'] = self.picture()
        return found

    def picture(self):
        """Return the digest of what ~snapshot saves."""
        with tempfile.TemporaryDirectory() as folder:
            self.master.setParam(tcpros.CALLER, f'{self.kind.node}/snapshot_dir', folder)
            # the first one loads OpenCV, which takes long when the disk has not been read yet
            accepted, told = self.call(f'{self.kind.node}/snapshot', timeout=COME_UP)
            files = os.listdir(folder)
            if not accepted or len(files) != 1:
                raise BenchError(f'no snapshot: {told!r}')
            with open(os.path.join(folder, files[0]), 'rb') as file:
                return hashlib.sha256(file.read()).hexdigest()


def serialized(message):
    """Return the bytes of a message."""
    class _Buffer(list):
        write = list.append
    buffer = _Buffer()
    message.serialize(buffer)
    return b''.join(buffer)


def ground_truth(data):
    """Return (x, y, z, quaternion) of an Odometry's bytes."""
    offset = 12  # header: seq, stamp
    for _ in range(2):  # frame_id and child_frame_id
        offset += TEXT_LENGTH.size + TEXT_LENGTH.unpack_from(data, offset)[0]
    return ODOMETRY_POSE.unpack_from(data, offset)


_FOUND = {}


def command_of(kind, subject):
    """Return the command of a kind of node; for the turtle simulator, the peer's if there is one."""
    folder = os.path.join(subject.folder, 'pictures')
    node_kinds.make_picture(folder)
    if subject.side != OURS and kind.key == 'turtlesim':
        return list(subject.command)
    key = kind.package, kind.executable
    if key not in _FOUND:
        _FOUND[key] = find_node(*key)
    return [*_FOUND[key], *node_kinds.arguments(kind, folder)]


@contextlib.contextmanager
def running(subject, *keys, before=(), **environment):
    """Yield {key: Node} of the kinds with these keys and what they need, all registered; end them afterwards.

    ``before``: a command in front of each, such as prlimit; ``environment``: changed variables, None removes one.
    """
    with contextlib.ExitStack() as stack:
        nodes = {}
        for kind in node_kinds.in_order(keys):
            nodes[kind.key] = stack.enter_context(started(subject, kind, before, **environment))
        for node in nodes.values():
            node.await_registered()
        yield nodes


@contextlib.contextmanager
def started(subject, kind, before=(), **environment):
    """Start a node of a kind; return its Node."""
    command = [*before, *command_of(kind, subject)]
    with subject.start(f'{kind.key} of {subject.side}', command, stdin=subprocess.PIPE, **environment) as child:
        yield Node(kind, child, subject)


def rate(receiver, seconds):
    """Return the rate [Hz] of messages over the next ``seconds``."""
    start = len(receiver.stamps)
    time.sleep(seconds)
    return median_rate(receiver.stamps[start:], SPAN)
