#!/usr/bin/env python3
"""mimic: copied and ignored values, remapping, its end."""
import math

import roslib.packages
import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose

from rostest_support.common import Collected, Process, SimulatorCase, run, until

MIMIC = roslib.packages.find_node('turtlesim', 'mimic')[0]
SPEEDS = [(0.5, 0.25), (0.0, -1.5), (1.0, 0.0), (0.0, 0.0)]  # (m/s, rad/s), exact as float32


class MimicTest(SimulatorCase):

    def start(self, *arguments, source='/input/pose', target='/output/cmd_vel'):
        """Start mimic, connect with it; return its Process."""
        process = Process(MIMIC, *arguments)
        self.addCleanup(process.stop)
        self.connect(source, target)
        return process

    def connect(self, source, target):
        """Wait until poses go in and Twists come out, then forget those."""
        self.received = Collected(target, Twist)
        self.poses_out = rospy.Publisher(source, Pose, queue_size=10, tcp_nodelay=True)
        until(self.poses_out.get_num_connections, f'mimic on {source}')
        until(lambda: self.poses_out.publish(Pose()) or self.received.messages, f'mimic on {target}')
        self.poses_out.publish(Pose(linear_velocity=9.0))
        until(lambda: self.received.messages[-1].linear.x == 9.0, 'the last one sent')
        self.poses_out.publish(Pose())  # at rest again
        until(lambda: self.received.messages[-1].linear.x == 0.0, 'the last one sent')
        self.received.messages.clear()

    def send(self, linear, angular):
        """Publish a pose and wait for the command that follows; return (linear.x, angular.z)."""
        seen = len(self.received.messages)
        self.poses_out.publish(Pose(x=1.0, y=2.0, theta=3.0, linear_velocity=linear, angular_velocity=angular))
        until(lambda: len(self.received.messages) > seen, f'a Twist for {linear}, {angular}')
        return self.received.messages[-1].linear.x, self.received.messages[-1].angular.z

    def assert_copies(self):
        self.assertEqual(SPEEDS, [self.send(*speeds) for speeds in SPEEDS])
        self.assertEqual(len(SPEEDS), len(self.received.messages), 'one Twist a pose')
        for message in self.received.messages:
            others = message.linear.y, message.linear.z, message.angular.x, message.angular.y
            self.assertEqual((0.0, 0.0, 0.0, 0.0), others)

    def test_mimic_copies_speeds(self):
        """One Twist a pose, with its speeds."""
        self.start()
        self.assert_copies()

    def test_mimic_remapped_by_namespace(self):
        """input:= and output:=, in a namespace."""
        self.start('input:=a/turtle1', 'output:=/b/turtle7', '__ns:=space',
                   source='/space/a/turtle1/pose', target='/b/turtle7/cmd_vel')
        self.assert_copies()

    def test_mimic_leaves_out_what_is_no_speed(self):
        """NaN, infinity, absurd values: nothing sent, one warning."""
        process = self.start()
        self.poses_out.publish(Pose(linear_velocity=math.nan))
        process.wait_for_output('Ignored a message on /input/pose: pose: linear_velocity is nan; it must be')
        for bad in (math.inf, -math.inf, 1e30):
            self.poses_out.publish(Pose(linear_velocity=bad))
            self.poses_out.publish(Pose(angular_velocity=bad))
        self.assertEqual((0.5, 0.25), self.send(0.5, 0.25))
        self.assertEqual(1, len(self.received.messages), self.received.messages)
        self.assertEqual(1, process.output().count('Ignored'), process.output())


if __name__ == '__main__':
    run(MimicTest)
