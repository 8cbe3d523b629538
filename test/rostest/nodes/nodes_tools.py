"""Helpers for the tests of all kinds of nodes: a master, nodes registered with it, and their registrations."""
import os
import signal
import subprocess
import sys
import tempfile
import xmlrpc.client

import roslib.packages

from rospy_support.own_master import start_master
from rostest_support import node_kinds
from rostest_support.common import Process, until

OWN_TURTLES = {'velocity_publisher': 'turtle7', 'stop_at_x': 'turtle3', 'drive_shape': 'turtle4',
               'teleport_tour': 'turtle5', 'draw_square': 'turtle6'}  # a turtle for each node that drives at once
OTHER_ROBOT = '/other_robot/cmd_vel'
CALLER = '/nodes_test'
TURTLES = '''import rospy
from turtlesim.srv import Spawn, TeleportAbsolute
for number in range(2, 8):
    rospy.ServiceProxy('/spawn', Spawn)(5.0, 1.0 + number, 0.0, 'turtle%d' % number)
rospy.ServiceProxy('/turtle1/teleport_absolute', TeleportAbsolute)(11.0, 11.0, 0.78)'''
START_DEADLINE = 60.0  # [s] for all kinds at once, on two loaded cores


class OwnMaster:
    """A rosmaster on a port of its own, which is asked for registrations by XML-RPC."""

    def __init__(self):
        self.uri = self.process = self._port = None

    def start(self):
        """Start it, again on its port after it was ended, and return when it answers."""
        self.uri, self.process = start_master(lambda command: Process(*command), self._port)
        self._port = int(self.uri.rsplit(':', 1)[1])

    def kill(self):
        """End it as a crash does."""
        self.process.process.kill()
        self.process.process.wait()

    def answers(self):
        """Return whether it answers."""
        try:
            return self.call('getPid') > 0
        except OSError:
            return False

    def call(self, method, *arguments):
        """Return the value of a call of its API; None where it refuses."""
        code, _, value = getattr(xmlrpc.client.ServerProxy(self.uri), method)(CALLER, *arguments)
        return value if code == 1 else None

    def registered(self, node):
        """Return the registrations of a node: (published, subscribed, services), sets of names."""
        return tuple({name for name, nodes in kind if node in nodes} for kind in self.call('getSystemState'))


class Nodes:
    """Nodes of several kinds beside a master, each a Process; they end with the test, whose addCleanup it gets."""

    def __init__(self, add_cleanup, master):
        self._master = master
        self._folder = tempfile.TemporaryDirectory()
        add_cleanup(self._folder.cleanup)
        add_cleanup(self.stop)
        node_kinds.make_picture(self._folder.name)
        self.running = {}  # NodeKind: Process

    def start(self, *kinds, under=None):
        """Start a node of each kind, and return when all that they have is registered.

        under: {kind: words of a command that starts it}.
        """
        for kind in kinds:
            command = [*(under or {}).get(kind, ()), *command_of(kind, self._folder.name)]
            self.running[kind] = Process(*command, stdin=subprocess.PIPE, ROS_MASTER_URI=self._master.uri)
        for kind in kinds:
            until(lambda kind=kind: not self.missing(kind), lambda kind=kind: f'{self.missing(kind)} of {kind.key}:\n'
                  f'{self.output(kind)}', START_DEADLINE)


    def missing(self, kind):
        """Return the names of a kind that the master does not know."""
        return node_kinds.missing(kind, self._master.registered(kind.node))

    def output(self, kind):
        """Return the output of a node."""
        return self.running[kind].output()

    def spawn_turtles(self):
        """Make a turtle for each node that drives one of its own, and put turtle1 to the wall."""
        subprocess.run([sys.executable, '-c', TURTLES], check=True, timeout=60.0,
                       env=dict(os.environ, ROS_MASTER_URI=self._master.uri))

    def stop(self):
        """End all nodes, those that need others first."""
        for process in self.running.values():
            if process.runs():
                process.process.send_signal(signal.SIGINT)
        for process in reversed(list(self.running.values())):
            process.stop()


def command_of(kind, folder):
    """Return the command that starts a node of a kind; ``folder`` has a picture."""
    return [roslib.packages.find_node(kind.package, kind.executable)[0], *node_kinds.arguments(kind, folder)]


def all_kinds(kinds=node_kinds.KINDS):
    """Return NodeKinds, those that drive with a turtle of their own, in an order in which they can be started."""
    kinds = node_kinds.in_order([kind.key for kind in kinds])
    return [on_own_turtle(kind) for kind in kinds]


def on_own_turtle(kind):
    """Return a kind with a turtle or robot of its own, if it is one that drives at once, and without a reset."""
    if kind.key in OWN_TURTLES:
        kind = node_kinds.on_turtle(kind, OWN_TURTLES[kind.key])
    if kind.key in ('ar_control', 'ar_maze'):  # one node drives the robot: drive_shape
        kind = kind._replace(arguments=(*kind.arguments, f'cmd_vel:={OTHER_ROBOT}'), published=(OTHER_ROBOT,))
    if kind.key == 'draw_square':
        kind = kind._replace(arguments=(*kind.arguments, 'reset:=clear'))  # it would take the other turtles away
    return kind
