#!/usr/bin/env python3
"""Simulators, camera, tracker, usb_cam and lessons for some minutes, beside clients that misbehave: nothing grows.

Every few seconds each node is called and heard. In between, clients of the simulators take turns: they never read,
send half a header, or call services from many threads at once. The environment's MINUTES sets how long.
"""
import contextlib
import os
import random
import re
import socket
import statistics
import time
import unittest
from concurrent.futures import ThreadPoolExecutor

import rosgraph
import rospy
from nav_msgs.msg import Odometry
from robotont_gazebo.srv import SetPose
from std_srvs.srv import Empty
from turtlesim.msg import Pose
from turtlesim.srv import Kill, SetPen, Spawn, TeleportAbsolute, TeleportRelative

from attacked_nodes import running
from rostest_support import tcpros
from rostest_support.common import registered_names, run
from rostest_support.tcpros import TROUBLE

MINUTES = float(os.environ.get('MINUTES', '2'))
KEYS = ('turtlesim', 'robotont', 'camera', 'tracker', 'usb_cam', 'goto_pose_server', 'pose_subscriber',
        'velocity_publisher')
TOPICS = {'turtlesim': ('/turtle1/pose', Pose, 62.5), 'robotont': ('/odom', Odometry, 30.0)}  # [Hz]
PERIOD = 2.0  # [s] between two samples
LOAD_EVERY = 3  # samples between two rounds of clients
WARM_UP = 1.0 / 3.0  # share of the run that is left out
FEWEST = 0.9  # share of the messages: a machine may stand still for a moment
GROWTH = 10.0  # [MB] in the middle of the last quarter more than in that of the first
MISBEHAVING = 50  # clients at once
CALLERS, STORM = 8, 1.0  # threads that call at once, and how long [s]
NAMES = tuple(f'storm{number}' for number in range(5))
START = -2.0, 0.0, 0.0  # x, y [m], yaw [rad] of the robot
SMALL_BUFFER = 4096  # [bytes] of a subscriber that never reads, so that it is full soon


def call(answers, name, kind, *values):
    """Call a service; note in the list ``answers`` whether it is answered. A refusal is an answer, too."""
    try:
        place = tcpros.address(rosgraph.Master(rospy.get_name()).lookupService(name))
        caller = tcpros.Caller(place, name, kind)
        with caller.socket:
            caller.call(*values)
    except socket.timeout:
        answers.append(False)
    except (*TROUBLE, rosgraph.MasterException):
        pass  # the turtle is gone in the meantime
    else:
        answers.append(True)


def never_read(nodes, _):
    """Subscribe and never read; return the connections."""
    kept = [tcpros.subscribe(nodes[key].peer.uri, topic, kind) for key, (topic, kind, _) in TOPICS.items()
            for _ in range(MISBEHAVING)]
    for connection in kept:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, SMALL_BUFFER)
    return kept


def half_headers(nodes, _):
    """Begin connections to both ports of every node and say no more; return the connections."""
    hello = tcpros.header(callerid=tcpros.CALLER, **tcpros.LOG)
    return [tcpros.connect(place, hello[:size * len(hello) // MISBEHAVING]) for node in nodes.values()
            for place in (node.peer.address, node.peer.slave_address) for size in range(0, MISBEHAVING, 10)]


def storm(_, answers):
    """Call the services of both simulators from many threads at once; leave turtle1 alone in the end."""
    end = time.monotonic() + STORM

    def client(seed):
        own = random.Random(seed)
        while time.monotonic() < end:
            name = own.choice(NAMES)
            call(answers, *own.choice((
                ('/spawn', Spawn, 5.0, 5.0, 0.0, name), ('/kill', Kill, name), ('/clear', Empty), ('/reset', Empty),
                ('/turtle1/set_pen', SetPen, own.randrange(256), 0, 0, 3, 0),
                ('/turtle1/teleport_absolute', TeleportAbsolute, own.uniform(1.0, 10.0), 5.0, 0.0),
                ('/turtle1/teleport_relative', TeleportRelative, 1.0, 1.0),
                ('/robotont_gazebo/set_pose', SetPose, own.uniform(-2.5, -1.5), 0.0, 0.0))))
    with ThreadPoolExecutor(CALLERS) as threads:
        list(threads.map(client, range(CALLERS)))
    call(answers, '/reset', Empty)
    call(answers, '/robotont_gazebo/set_pose', SetPose, *START)
    return []


def sample(peer):
    """Return (memory [MB], descriptors, threads) of a node.

    The memory is what the process has filled itself. Its share of files such as libraries grows when another program
    that uses them ends.
    """
    with open(f'/proc/{peer.pid}/smaps_rollup', encoding='utf-8') as file:
        found = re.findall(r'^(?:Pss_Anon|Pss_Shmem|SwapPss):\s*(\d+) kB$', file.read(), re.MULTILINE)
    return sum(map(int, found)) * 1024 / 1e6, peer.descriptors(), peer.threads()


class SoakTest(unittest.TestCase):

    def test_nodes_beside_clients_that_misbehave(self):
        with contextlib.ExitStack() as stack:
            nodes = running(stack, KEYS)
            self.receivers = {key: tcpros.Receiver(tcpros.subscribe(nodes[key].peer.uri, topic, kind))
                              for key, (topic, kind, _) in TOPICS.items()}
            for receiver in self.receivers.values():
                stack.callback(receiver.close)
            samples, answers = self.soak(nodes)
            self.assertEqual([], sum((node.troubles() for node in nodes.values()), []))
        self.assertTrue(answers and all(answers), f'{answers.count(False)} of {len(answers)} calls have no answer')
        for key, found in samples.items():
            self.assert_no_growth(key, list(zip(*found[int(WARM_UP * len(found)):])))

    def soak(self, nodes):
        """Watch the nodes; return ({key: samples}, whether each call of a client was answered)."""
        samples, answers, kept = {key: [] for key in nodes}, [], []
        begun, count = time.monotonic(), round(60.0 * MINUTES / PERIOD)
        for receiver in self.receivers.values():
            receiver.stamps.clear()
        for number in range(count):
            for key, node in nodes.items():
                samples[key].append(sample(node.peer))
            if number % LOAD_EVERY == 0:
                for node in nodes.values():
                    node.peer.answers()
                kept = (never_read, half_headers, storm)[number // LOAD_EVERY % 3](nodes, answers)
            elif number % LOAD_EVERY == LOAD_EVERY - 1:
                for connection in kept:
                    connection.close()
            time.sleep(max(0.0, begun + (number + 1) * PERIOD - time.monotonic()))
        elapsed = time.monotonic() - begun
        for key, (topic, _, rate) in TOPICS.items():
            self.assertGreater(len(self.receivers[key].stamps), FEWEST * rate * elapsed, topic)
        published, _, _ = registered_names('/turtlesim')
        self.assertEqual(['/turtle1/pose'], [name for name in published if name.endswith('/pose')])
        return samples, answers

    def assert_no_growth(self, key, columns):
        for what, values, spare in zip(('MB', 'descriptors', 'threads'), columns, (GROWTH, 0, 0)):
            quarter = len(values) // 4
            first, last = statistics.median(values[:quarter]), statistics.median(values[-quarter:])
            print(f'{key}: {first:.4g}, then {last:.4g} {what}')
            self.assertLessEqual(last, first + spare, f'{key}: {what}')


if __name__ == '__main__':
    run(SoakTest)
