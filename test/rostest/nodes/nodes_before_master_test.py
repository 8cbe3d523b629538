#!/usr/bin/env python3
"""Nodes and programs that are started before roscore, and the last command of a program that is interrupted."""
import signal
import sys
import unittest

import roslib.packages
from geometry_msgs.msg import Twist

from nodes_tools import OwnMaster
from rostest_support.common import DEADLINE, SIMULATOR, Collected, Process, run, until

WAITS = 'There is no ROS master at {uri}. Waiting for it: type roscore'
PROGRAM = '''import rospy
from geometry_msgs.msg import Twist

rospy.init_node('student')
pub = rospy.Publisher('student/cmd_vel', Twist, queue_size=10)
rospy.on_shutdown(lambda: pub.publish(Twist()))
twist = Twist()
twist.linear.x = 1.0
rate = rospy.Rate({rate})
while not rospy.is_shutdown():
    pub.publish(twist)
    rospy.loginfo('published')
    rate.sleep()
'''
TIMES = 5


def student(rate, *arguments, **environment):
    return Process(sys.executable, '-c', PROGRAM.format(rate=rate), *arguments, **environment)


class BeforeMasterTest(unittest.TestCase):

    def without_master(self):
        """Return a master that does not run, and the nodes that wait for it."""
        master = OwnMaster()
        master.start()
        master.kill()
        publisher = roslib.packages.find_node('turtle_robotont', 'velocity_publisher.py')[0]
        environment = {'ROS_MASTER_URI': master.uri}
        nodes = {'/turtlesim': Process(SIMULATOR, '_window:=false', **environment),
                 '/velocity_publisher': Process(publisher, '_linear:=2.0', '__name:=velocity_publisher', **environment),
                 '/student': student(10, **environment)}
        for process in nodes.values():
            self.addCleanup(process.stop)
        for process in nodes.values():
            process.wait_for_output(WAITS.format(uri=master.uri).replace('.', r'\.'))
        return master, nodes

    def test_nodes_wait_for_the_master(self):
        """Each reports the missing master once; when roscore runs, all are registered, with their parameters."""
        master, nodes = self.without_master()
        master.start()
        self.addCleanup(lambda: master.process.stop())
        for node, process in nodes.items():
            until(lambda node=node: master.registered(node)[0] > {'/rosout'}, lambda p=process: p.output(), DEADLINE)
            self.assertTrue(process.runs())
            self.assertEqual(1, process.output().count('There is no ROS master'), process.output())
            self.assertNotIn('Traceback', process.output())
        self.assertIs(False, master.call('getParam', '/turtlesim/window'))
        self.assertEqual(2.0, master.call('getParam', '/velocity_publisher/linear'))

    def test_ctrl_c_ends_the_wait(self):
        """With a short message, and the exit code that rospy's error has."""
        _, nodes = self.without_master()
        for process in nodes.values():
            process.process.send_signal(signal.SIGINT)
        for process in nodes.values():
            self.assertEqual(1, process.process.wait(DEADLINE), process.output())
            self.assertNotIn('Traceback', process.output())
            self.assertLessEqual(len(process.output().splitlines()), 2, process.output())

    def test_the_last_command_of_an_interrupted_program_is_its_hooks(self):
        """The Twist() of rospy.on_shutdown arrives, and none after it, in a slow loop as in one that never rests."""
        received = Collected('student/cmd_vel', Twist)
        for rate in (10, 100000):
            for _ in range(TIMES):
                received.messages.clear()
                program = student(rate)
                self.addCleanup(program.stop)
                received.next(lambda twist: twist.linear.x == 1.0)
                program.process.send_signal(signal.SIGINT)
                self.assertEqual(0, program.process.wait(DEADLINE), program.output())
                self.assertNotIn('Traceback', program.output())
                until(lambda: received.messages[-1] == Twist(), lambda: f'Twist() at last: {received.messages[-3:]}')


if __name__ == '__main__':
    run(BeforeMasterTest)
