#!/usr/bin/env python3
"""Private parameters on one roscore: those of a command line end with its node, all others are told by the next one."""
import re
import subprocess
import unittest

import roslib.packages
import rosnode
import rospy

from rostest_support.common import DEADLINE, Process, own_simulator, run, until

STEP_DEADLINE = 90.0  # [s] for a command of the course; drives take up to 10
DRIVE_SHAPE = roslib.packages.find_node('turtle_robotont', 'drive_shape.py')[0]
ROBOTONT = roslib.packages.find_node('robotont_gazebo', 'robotont_gazebo')[0]
DRIVES = [  # arguments of drive_shape.py, and what it says that it draws
    ((), 'square, starting at (5.54, 5.54)'),
    (('_shape:=corners', '_corners:=[[8,6],[6,8],[4,6]]', '_speed:=4'), 'corners, starting at (8.00, 6.00)'),
    (('_robot:=true',), 'square, starting at (-2.00, '),
    ((), 'square, starting at (')]
OLD = 'from an earlier run'


class ParametersLeftTest(unittest.TestCase):

    def simulator(self):
        simulator = own_simulator('_window:=false')
        self.addCleanup(simulator.stop)
        until(lambda: '/turtlesim' in rosnode.get_node_names(), 'the simulator')
        return simulator

    def test_one_command_line_after_the_other(self):
        """No run changes what another one does."""
        self.simulator()
        robot = Process(ROBOTONT, '_world:=minimaze', '_x:=-2.0')
        self.addCleanup(robot.stop)
        until(lambda: '/robotont_gazebo' in rosnode.get_node_names(), 'the robot')
        for arguments, drawn in DRIVES:
            done = subprocess.run([DRIVE_SHAPE, *arguments], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                  text=True, timeout=STEP_DEADLINE, check=False)
            self.assertEqual(0, done.returncode, done.stdout)
            self.assertIn(f'Drawing: {drawn}', done.stdout)
            self.assertNotIn(OLD, done.stdout)
        self.assertFalse(rospy.get_param('/drive_shape', {}))

    def test_others_are_told_and_stay(self):
        """Of a killed node and of rosparam; not those of the command line."""
        self.simulator()
        first = Process(DRIVE_SHAPE, '_shape:=circle', '_size:=0.5', '_speed:=0.05', '_strafe:=false')
        first.wait_for_output('Drawing: circle')
        first.process.kill()
        first.stop()
        rospy.set_param('/drive_shape/speed', 4.0)
        with Process(DRIVE_SHAPE, '_size:=1.0') as second:
            second.wait_for_output(re.escape(
                f'/drive_shape has parameters {OLD}: shape=circle, speed=4.0, strafe=False; rosparam delete '
                '/drive_shape forgets'))
            until(lambda: not second.runs(), 'the end of the drive', STEP_DEADLINE)
        self.assertEqual({'shape': 'circle', 'speed': 4.0, 'strafe': False}, rospy.get_param('/drive_shape'))
        rospy.delete_param('/drive_shape')

    def test_a_value_that_somebody_else_has_set_meanwhile_stays(self):
        simulator = own_simulator('_window:=false', '_background_r:=7', '_background_g:=8')
        simulator.wait_for_output('Spawning')
        rospy.set_param('/turtlesim/background_r', 200)
        simulator.stop()
        left = rospy.get_param('/turtlesim')
        self.assertEqual((200, False, False), (left.get('background_r'), 'background_g' in left, 'window' in left))
        with own_simulator('_window:=false') as again:
            again.wait_for_output(f'{OLD}: background_r=200;')
        rospy.delete_param('/turtlesim')

    def test_a_node_that_takes_the_name_keeps_its_parameters(self):
        """The older one ends, and deletes nothing of the newer one's."""
        first = own_simulator('_window:=false', '_background_r:=7')
        first.wait_for_output('Spawning')
        second = own_simulator('_window:=false', '_background_r:=7')
        self.addCleanup(second.stop)
        until(lambda: not first.runs(), 'the end of the first one')
        self.assertEqual(7, rospy.get_param('/turtlesim/background_r'))
        first.stop()

    def test_what_a_launch_file_gives_is_not_old(self):
        """A launch file that starts again finds its earlier parameters; /use_sim_time ends with the simulator."""
        for _ in range(2):
            with Process('roslaunch', 'turtle_robotont', 'drive_shape.launch', 'sim_rate:=max', 'size:=1.5') as launch:
                until(lambda launch=launch: not launch.runs(), 'the end of the launch', STEP_DEADLINE)
                self.assertRegex(launch.output(), 'Drawn in')
                self.assertNotIn(OLD, launch.output())
            self.assertFalse(rospy.has_param('/use_sim_time'))
        with Process(DRIVE_SHAPE) as alone:
            alone.wait_for_output(f'{OLD}: corners=.*size=1.5', DEADLINE)
        rospy.delete_param('/drive_shape')
        rospy.delete_param('/turtlesim')


if __name__ == '__main__':
    run(ParametersLeftTest)
