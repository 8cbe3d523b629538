#!/usr/bin/env python3
"""Nodes that drive are ended, each in its own way, all at once: no traceback, the right exit code, the vehicle stopped.

The environment's ROUNDS sets how often; the ways to end take turns from round to round.
"""
import contextlib
import os
import signal
import time
import unittest
import xmlrpc.client

from geometry_msgs.msg import Twist
from turtle_robotont.srv import DriveTo

from nodes_tools import Nodes, OwnMaster, on_own_turtle
from rospy_support import registration
from rostest_support import node_kinds
from rostest_support.common import Collected, run, until
from rostest_support.course import BackgroundCall

ROUNDS = int(os.environ.get('ROUNDS', '2'))
END_DEADLINE = 60.0  # [s] for all to end; well under a second each where the machine is not loaded
CODES = {'velocity_publisher': 0, 'stop_at_x': 0, 'drive_shape': 1, 'drive_server': 0, 'draw_square': 0, 'mimic': 0,
         'drive_shape_robot': 1, 'ar_control': 0, 'follower': 0}  # 1: it did not get where it was told to
SIMULATORS = 'turtlesim', 'robotont', 'broadcaster', 'follower_broadcaster'  # and the tf frames that the others need
TOPICS = {'drive_shape_robot': '/cmd_vel'}


def interrupt(process, _):
    process.send_signal(signal.SIGINT)


def terminate(process, _):
    process.send_signal(signal.SIGTERM)


def hang_up(process, _):
    process.send_signal(signal.SIGHUP)


def kill_by_name(process, uri):
    """As rosnode kill does."""
    with contextlib.suppress(OSError, xmlrpc.client.Error):
        xmlrpc.client.ServerProxy(uri).shutdown('/rosnode', 'user request')


def both(process, uri):
    """Two ends at once, by signals and from outside."""
    process.send_signal(signal.SIGTERM)
    process.send_signal(signal.SIGINT)
    kill_by_name(process, uri)


def outside_first(process, uri):
    """Two ends at once, from outside and by a signal."""
    kill_by_name(process, uri)
    process.send_signal(signal.SIGINT)


WAYS = interrupt, terminate, kill_by_name, both, outside_first, hang_up
WAYS_OF_LESSONS = interrupt, terminate, kill_by_name  # those that rospy itself knows


def way_of(kind, number):
    """Return how a node is ended when its turn has this number."""
    ways = WAYS_OF_LESSONS if kind.lesson else WAYS
    return ways[number % len(ways)]


class EndTest(unittest.TestCase):
    master = None  # an OwnMaster

    def setUp(self):
        """Start both simulators, and a turtle for each node that drives one."""
        registration.keep_registered()  # this node, too, hears the next nodes after a new master
        self.nodes = Nodes(self.addCleanup, self.master)
        self.nodes.start(*(node_kinds.BY_KEY[key] for key in SIMULATORS))
        self.kinds = [on_own_turtle(node_kinds.BY_KEY[key]) for key in CODES]
        self.kinds = [kind._replace(arguments=(*kind.arguments, '_mode:=forward', '_rate:=50'), subscribed=())
                      if kind.key == 'ar_control' else kind for kind in self.kinds]
        self.nodes.spawn_turtles()
        self.velocities = {kind.key: Collected(self.topic(kind), Twist) for kind in self.kinds}

    def topic(self, kind):
        """Return the topic on which a node sends velocities."""
        return TOPICS.get(kind.key) or next(name for name in kind.published if name.endswith('/cmd_vel'))

    def test_nodes_end(self):
        wrong = []
        for number in range(ROUNDS):
            wrong += self.round(number, master_away=number % 4 == 1)
        print(f'{ROUNDS * len(self.kinds)} ends, {len(wrong)} wrong')
        self.assertFalse(wrong, '\n'.join(wrong))

    def round(self, number, master_away):
        """Start all nodes, end them while they drive; return the errors."""
        for kind in self.kinds:
            self.velocities[kind.key].messages.clear()
        self.nodes.start(*self.kinds)
        BackgroundCall('/turtle1/drive_to', DriveTo, 5.5, 9.0 if number % 2 else 2.0, 0.0, False, 0.3, 0.0)
        for kind in self.kinds:
            self.velocities[kind.key].next(moves, f'{kind.key} driving')
        uris = {kind: self.master.call('lookupNode', kind.node) for kind in self.kinds}
        if master_away:
            self.master.kill()
        for index, kind in enumerate(self.kinds):
            way_of(kind, index + number)(self.nodes.running[kind].process, uris[kind])
        wrong = []
        for index, kind in enumerate(self.kinds):
            output = self.ended(kind)
            if output:
                way = way_of(kind, index + number).__name__
                wrong.append(f'{kind.key}, {way}, master {"away" if master_away else "there"}: {output}')
        if master_away:
            self.master.start()
            until(lambda: not self.nodes.missing(node_kinds.BY_KEY['turtlesim'])
                  and not self.nodes.missing(node_kinds.BY_KEY['robotont']), 'the simulators registered')
        return wrong

    def ended(self, kind):
        """Wait for the end of a node; return its errors."""
        process, collected = self.nodes.running.pop(kind), self.velocities[kind.key]
        try:
            until(lambda: not process.runs(), 'the end', END_DEADLINE)
        except AssertionError:
            return f'did not end:\n{process.output()}'
        finally:
            output, code = process.output(), process.process.poll()
            process.stop()
        if code != CODES[kind.key]:
            return f'exit code {code}:\n{output}'
        if any(word in output for word in ('Traceback', 'Exception', 'Fatal Python', 'did not end within')):
            return output
        deadline = time.monotonic() + 10.0
        while collected.messages[-1] != Twist() and time.monotonic() < deadline:
            time.sleep(0.01)
        return '' if collected.messages[-1] == Twist() else f'not stopped: {collected.messages[-1]}\n{output}'


def moves(twist):
    """Return whether a Twist moves the vehicle."""
    return twist != Twist()


if __name__ == '__main__':
    EndTest.master = OwnMaster()
    EndTest.master.start()
    os.environ['ROS_MASTER_URI'] = EndTest.master.uri
    try:
        run(EndTest)
    finally:
        EndTest.master.process.stop()
