#!/usr/bin/env python3
"""Of what ./run starts, only the XML-RPC servers of C++ nodes can be reached from another machine.

One network namespace probes all ports of another, in which demo, grading, rostest and shell run. There, ss lists the
sockets that accept connections from everywhere, UDP included.
"""
import os
import re
import subprocess
import sys
import tempfile
import unittest

import listening
import two_machines_test
from rostest_support.common import Process, run, until
from rostest_support.node_pages import REPOSITORY
from two_machines_test import LAPTOP, ROBOT, Machine

ROBOT_6 = 'fd77::1'
UNNAMED = '?'  # a process that ends while ss runs
DEADLINE = 140.0  # [s] for all of it; on an idle machine it takes 20
EXPOSED_PORT = 4567  # of a program that has nothing to do with ./run: the scan has to find it
FOREIGN = 'env', '-u', 'ROS_HOSTNAME', '-u', 'ROS_MASTER_URI'
SERVER = f'''
import socket
server = socket.socket(socket.AF_INET6)
server.bind(("::", {EXPOSED_PORT}))
server.listen()
print("listens", flush=True)
while True:
    server.accept()[0].close()
'''
STUDENT = '''
import socket, rospy
opened = []
for family, kind, address in ((socket.AF_INET, socket.SOCK_STREAM, ""), (socket.AF_INET6, socket.SOCK_STREAM, "::"),
                              (socket.AF_INET, socket.SOCK_DGRAM, ""), (socket.AF_INET6, socket.SOCK_DGRAM, "::")):
    opened.append(socket.socket(family, kind))
    opened[-1].bind((address, 0))
    if kind == socket.SOCK_STREAM:
        opened[-1].listen()
opened.append(socket.socket())
opened[-1].listen()
rospy.init_node("server")
rospy.spin()
'''
NODES = {'rosmaster', 'rosout', 'robot_state_pub', 'robotont_gazebo', 'turtlesim_node'}  # as ss shortens them

XMLRPC_OF_CPP = 'rosout', 'robot_state_pub'  # roscpp's XML-RPC servers ignore ROS_HOSTNAME


class UnreachableTest(unittest.TestCase):

    def setUp(self):
        self.inside, self.outside = Machine(ROBOT), Machine(LAPTOP)
        self.addCleanup(self.outside.remove)
        self.addCleanup(self.inside.remove)
        two_machines_test.connect(self.inside, self.outside)
        for machine, address in ((self.inside, ROBOT_6), (self.outside, 'fd77::2')):
            machine.do('ip', 'address', 'add', f'{address}/64', 'dev', 'cable', 'nodad')

    def start(self, machine, *command):
        process = Process(*machine.command(*command))
        self.addCleanup(process.stop)
        return process

    def test_what_is_reachable_from_another_machine(self):
        """One XML-RPC port of each C++ node, and nothing else of ROS, of Python nodes or of a graded program."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        student = os.path.join(folder.name, 'student.py')
        with open(student, 'w', encoding='utf-8') as file:
            file.write(STUDENT)
        self.start(self.inside, *FOREIGN, sys.executable, '-c', SERVER).wait_for_output('listens')
        scanner = (sys.executable, listening.__file__, ROBOT, ROBOT_6)
        ours = (*FOREIGN, os.path.join(REPOSITORY, 'run'))
        shell = self.start(self.inside, *ours, 'shell', '-c', 'roslaunch -p 11377 robotont_gazebo gazebo.launch')
        running = [
            self.start(self.inside, *ours, 'demo', '--output', os.path.join(folder.name, 'demo'), 'First publisher'),
            self.start(self.inside, *ours, 'grade', 'publish_circle', '--output', os.path.join(folder.name, 'grade'),
                       '--', sys.executable, student),
            self.start(self.inside, 'rostest', '--results-base-dir', folder.name, os.path.join(  # as in ./run test
                REPOSITORY, 'packages/robotont/robotont_gazebo/test/rostest/robotont_basic.test'))]
        scans, exposed, seen = [], set(), set()

        def look():
            lines = subprocess.run(self.inside.command('ss', '-Hlntup'), stdout=subprocess.PIPE, text=True, check=True,
                                   timeout=20).stdout.splitlines()
            seen.update(re.findall(r'"([^"]*)"', ' '.join(lines)))
            exposed.update(listening.exposed(lines))
            if not scans and NODES <= seen:
                scans.append(self.start(self.outside, *scanner))
            return scans and not any(process.runs() for process in [*running, *scans])
        until(look, lambda: f'an end of {[process.process.args for process in running if process.runs()]}; '
                            f'seen: {seen}', DEADLINE)
        self.assertTrue(shell.runs(), shell.output())
        for process in running[:2]:
            self.assertIn(process.process.returncode, (0, 1), process.output())  # the student's program fails
        named = {each[:2] for each in exposed if each[2] != UNNAMED}
        exposed = {each for each in exposed if each[2] != UNNAMED or each[:2] not in named}
        of_cpp = {each for each in exposed if each[0] == 'tcp' and each[2] in XMLRPC_OF_CPP}
        self.assertEqual({('tcp', f'*:{EXPOSED_PORT}')}, {each[:2] for each in exposed - of_cpp}, exposed)
        self.assertEqual(set(XMLRPC_OF_CPP), {program for _, _, program in of_cpp})
        known = {f'{ROBOT} {address.rpartition(":")[2]}' for _, address, _ in of_cpp}
        self.assertEqual([f'{ROBOT} {EXPOSED_PORT}', f'{ROBOT_6} {EXPOSED_PORT}'],
                         [line for line in scans[0].output().splitlines() if line not in known])


if __name__ == '__main__':
    two_machines_test.main(lambda: run(UnreachableTest))
