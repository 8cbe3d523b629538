#!/usr/bin/env python3
"""A master that goes away and comes back, however it does: every kind of node but lessons registers again all it had.

``RESTARTS=50 rosrun ...`` or the environment of the test sets how often the master is killed.
"""
import os
import signal
import subprocess
import sys
import time
import unittest

from nodes_pages import names_and_types, wrong_pages
from nodes_tools import Nodes, OwnMaster, all_kinds
from rostest_support.common import run, until

RESTARTS = int(os.environ.get('RESTARTS', '3'))
RETURN_DEADLINE = 60.0  # [s] within which all is registered again; 1 to 3 s where the machine is not loaded
ABSENCE = 2.0  # [s] in which nodes look for the master more than once
LISTENER = '''import rospy
rospy.init_node('listener')
for topic in '/turtle1/pose', '/odom', '/ar_pose_marker', '/usb_cam/image_raw', '/fake/odom', '/rosout':
    rospy.wait_for_message(topic, rospy.AnyMsg, 20.0)'''
LINES = 'does not answer', 'registered again', 'answers again'


class MasterTest(unittest.TestCase):

    maxDiff = None

    @classmethod
    def setUpClass(cls):
        """Start a master and a node of every kind, which offers all that it can."""
        cls.master = OwnMaster()
        cls.master.start()
        cls.addClassCleanup(lambda: cls.master.process.stop())
        cls.nodes = Nodes(cls.addClassCleanup, cls.master)
        kinds = [kind._replace(arguments=(*kind.arguments, '_model:=robotont_gazebo_lidar'))
                 if kind.key == 'robotont' else kind for kind in all_kinds()]
        simulators = [kind for kind in kinds if not kind.needs]
        cls.nodes.start(*simulators)
        cls.nodes.spawn_turtles()
        cls.nodes.start(*(kind for kind in kinds if kind not in simulators))
        cls.names = {kind: cls.master.registered(kind.node) for kind in cls.nodes.running if not kind.lesson}
        cls.parameters = {kind: {name: cls.master.call('getParam', name)
                                 for name in (*kind.parameters, f'{kind.node}/background_g')
                                 if cls.master.call('hasParam', name)} for kind in cls.names}
        cls.types = {kind: names_and_types(cls.master, kind) for kind in cls.nodes.running}

    def test_nodes_publish_subscribe_and_serve_what_their_pages_say(self):
        """No more, and no less."""
        self.assertEqual([], wrong_pages(self.types))

    def lacking(self):
        """Return the missing registrations of the nodes that still run: a drive may have arrived."""
        running = [kind for kind in self.names if self.nodes.running[kind].runs()]
        found = [f'{kind.key}: {before - now}' for kind in running
                 for before, now in zip(self.names[kind], self.master.registered(kind.node)) if not before <= now]
        return found + [name for kind in running for name, value in self.parameters[kind].items()
                        if self.master.call('getParam', name) != value]

    def back(self):
        """Wait until all is registered as before; return how long that took [s] after the master's first answer."""
        begin = time.monotonic()
        until(lambda: not self.lacking(), lambda: f'registered again: {self.lacking()}', RETURN_DEADLINE)
        return time.monotonic() - begin

    def test_nodes_master_returns(self):
        """Killed: started anew at once, or after a while; twice in a row; and one that only stands still."""
        self.assertGreaterEqual(len(self.names), 16)
        self.assertGreater(sum(map(len, self.parameters.values())), 20)
        took = []
        for number in range(RESTARTS):
            self.start_ended()
            self.master.kill()
            if number % 3 == 1:
                time.sleep(ABSENCE)
            self.master.start()
            if number % 3 == 2:  # again while they register
                self.master.kill()
                self.master.start()
            took.append(self.back())
        print('registered again after [s]:', *(f'{one:.2f}' for one in sorted(took)))
        self.master.process.process.send_signal(signal.SIGSTOP)
        time.sleep(ABSENCE)
        self.master.process.process.send_signal(signal.SIGCONT)
        self.back()
        self.assert_connected()
        self.assert_all_run()

    def start_ended(self):
        """Restart nodes that have reached their goals, which happens in a long campaign."""
        for kind in self.names:
            process = self.nodes.running[kind]
            if not process.runs():
                self.assertEqual(0, process.process.poll(), f'{kind.key}: {process.output()}')
                self.nodes.start(kind)
                self.nodes.running[kind].wait_for_output('Parameters: ')  # it asks the master for them

    def assert_connected(self):
        """A subscriber that comes now hears the nodes."""
        subprocess.run([sys.executable, '-c', LISTENER], check=True, timeout=60.0,
                       env=dict(os.environ, ROS_MASTER_URI=self.master.uri))

    def assert_all_run(self):
        """No node has ended, and each has said once that the master was away, and once that it is back."""
        for kind in self.names:
            process = self.nodes.running[kind]
            self.assertIn(process.process.poll(), (None, 0), f'{kind.key}: {process.output()}')
            lines = process.output().splitlines()
            output = [line for line in lines if any(text in line for text in LINES)]
            self.assertLessEqual(len(output), 2 * (2 * RESTARTS + 1), f'{kind.key}:\n' + '\n'.join(output))
            self.assertFalse([line for line in lines if 'Traceback' in line or 'Unable to' in line], process.output())


if __name__ == '__main__':
    run(MasterTest)
