"""Nodes under attack: started with what they need, watched in /proc, asked for their state. No rospy."""

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
    """Tell on stderr what is going on; stdout is the table's."""
    print(text, file=sys.stderr, flush=True)


def until(condition, what, deadline=COME_UP):
    """Poll until ``condition()`` is true and return its value; BenchError after ``deadline`` [s]."""
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
        time.sleep(POLL)


class Node:
    """A running node. kind: a NodeKind; child: its process, which may be a wrapper of the node's."""

    def __init__(self, kind, child, subject):
        self.kind, self.child, self.subject = kind, child, subject
        self.uri = self.pid = None
        self._of_thread = threading.local()

    @property
    def master(self):
        """The master's API, a connection for each thread."""
        if not hasattr(self._of_thread, 'master'):
            self._of_thread.master = tcpros.api(self.subject.uri)
        return self._of_thread.master

    def await_registered(self, deadline=COME_UP):
        """Return once all its names are with the master."""
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
        """(published, subscribed, services) that the master knows of it, sets."""
        state = self.master.getSystemState(tcpros.CALLER)[2]
        return tuple({name for name, nodes in kind if self.kind.node in nodes} for kind in state)

    def missing(self):
        """What it must have registered and has not; of a peer only what a turtlesim has."""
        left = node_kinds.missing(self.kind, self.registered())
        if self.subject.side == OURS:
            return left
        return [name for name in left if not name.startswith(self.kind.node + '/')]

    def runs(self):
        """Whether its process lives."""
        return self.child.runs()

    def descriptors(self):
        """How many it has open."""
        return psutil.Process(self.pid).num_fds()

    def threads(self):
        """How many it has."""
        return psutil.Process(self.pid).num_threads()

    def memory(self):
        """Resident memory [MB]."""
        return psutil.Process(self.pid).memory_info().rss / 1e6

    def peak_memory(self):
        """The most resident memory [MB] that there was."""
        return peak_memory(self.pid) / 1e6

    def service_place(self, name):
        """(host, port) of a service."""
        code, status, uri = self.master.lookupService(tcpros.CALLER, name)
        if code != 1:
            raise tcpros.Closed(status)
        return tcpros.address(uri)

    def caller(self, name, kind=None, timeout=tcpros.DEADLINE):
        """A persistent connection to one of its services, by absolute name."""
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
        """A Receiver of a topic, without one: of the simulator's poses."""
        topic, kind = (topic, kind) if topic else FRESH[self.kind.key]
        return tcpros.Receiver(tcpros.subscribe(self.uri, topic, kind))

    def message(self, topic, kind):
        """The bytes of a message that is published after this was called, or of a latched one."""
        connection = tcpros.subscribe(self.uri, topic, kind)
        try:
            return tcpros.receive_frame(connection)
        finally:
            connection.close()

    def tcpros_place(self):
        """(host, port) on which it takes connections of services and subscribers."""
        published = self.kind.published
        if self.kind.services:
            return self.service_place(self.kind.services[0])
        topics = published or ('/rosout',)
        return tuple(tcpros.api(self.uri).requestTopic(tcpros.CALLER, topics[0], [['TCPROS']])[2][1:3])

    def state(self):
        """All that nothing but a legal request may change: poses and picture, or the robot's pose and world."""
        if self.kind.key == 'robotont':
            return {'pose': ground_truth(self.message('/robotont_gazebo/ground_truth', Odometry)),
                    'world': self.message('/robotont_gazebo/world', String)}
        topics = sorted(topic for topic in self.registered()[0] if topic.endswith('/pose'))
        found = {topic: POSE.unpack(self.message(topic, Pose)) for topic in topics}
        if self.subject.side == OURS:
            found['canvas'] = self.picture()
        return found

    def picture(self):
        """The digest of what ~snapshot saves."""
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
    """The bytes of a message."""
    class _Buffer(list):
        write = list.append
    buffer = _Buffer()
    message.serialize(buffer)
    return b''.join(buffer)


def ground_truth(data):
    """(x, y, z, quaternion) of an Odometry's bytes."""
    offset = 12  # header: seq, stamp
    for _ in range(2):  # frame_id and child_frame_id
        offset += TEXT_LENGTH.size + TEXT_LENGTH.unpack_from(data, offset)[0]
    return ODOMETRY_POSE.unpack_from(data, offset)


_FOUND = {}


def command_of(kind, subject):
    """The command of a kind of node, of a peer's for the turtle simulator."""
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
    """{key: Node} of the kinds with these keys and what they need, registered; ended afterwards.

    before: a command in front of each, such as prlimit; environment: changed variables, None takes one away.
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
    """A Node of a kind that has just been started."""
    command = [*before, *command_of(kind, subject)]
    with subject.start(f'{kind.key} of {subject.side}', command, stdin=subprocess.PIPE, **environment) as child:
        yield Node(kind, child, subject)


def rate(receiver, seconds):
    """Messages a second [Hz] over the next ``seconds``."""
    start = len(receiver.stamps)
    time.sleep(seconds)
    return median_rate(receiver.stamps[start:], SPAN)
