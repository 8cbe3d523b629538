#!/usr/bin/env python3
"""velocity_publisher.py: its messages, its topic, and its end. For the default rate see rate_test."""
import signal

from geometry_msgs.msg import Twist, Vector3

from rostest_support.common import run
from rostest_support.course import STOP, CourseCase

RATE_TOLERANCE = 2.0  # [Hz] of 20


def twist(linear, angular):
    return Twist(Vector3(linear, 0.0, 0.0), Vector3(0.0, 0.0, angular))


class VelocityPublisherTest(CourseCase):

    def test_velocity_publisher_default(self):
        """0.5 m/s and 0.2 rad/s, and the turtle obeys."""
        self.assertEqual([twist(0.5, 0.2)] * 5, self.commands().more(5))
        pose = self.poses().next(lambda pose: pose.linear_velocity > 0.0, 'the turtle driving')
        self.assertEqual((0.5, 0.2), (pose.linear_velocity, round(pose.angular_velocity, 6)))

    def test_velocity_publisher_parameters(self):
        """~linear, ~angular and ~rate."""
        commands = self.commands()
        commands.more(1)
        self.assertAlmostEqual(20.0, commands.rate(60, span=5), delta=RATE_TOLERANCE)
        self.assertEqual([twist(-1.5, 0.75)] * 60, commands.messages[:60])

    def test_velocity_publisher_remap(self):
        """turtle1/cmd_vel:= on the command line."""
        self.call('spawn', 2.0, 2.0, 0.0, 'anna')
        other, first = self.commands('anna'), self.poses()
        self.start('velocity_publisher.py', 'turtle1/cmd_vel:=anna/cmd_vel')
        self.assertEqual([twist(0.5, 0.2)] * 3, other.more(3))
        self.poses('anna').next(lambda pose: pose.x > 2.1, 'anna driving')
        self.assertEqual(first.messages[0], first.messages[-1], 'turtle1 stays')

    def test_velocity_publisher_stops_the_turtle(self):
        """Ctrl-C, rosnode kill's shutdown and SIGTERM: one Twist of zeros is the last."""
        poses, commands = self.poses(), self.commands()
        for end in (signal.SIGINT, signal.SIGTERM):
            with self.subTest(end=end):
                process = self.start('velocity_publisher.py', '_linear:=0.2')
                poses.next(lambda pose: pose.linear_velocity > 0.0, 'the turtle driving')
                begin = len(commands.messages)
                process.process.send_signal(end)
                self.ended(process)
                self.assert_stopped_by(poses, commands, len(poses.messages))
                self.assertEqual(1, commands.messages[begin:].count(STOP))


if __name__ == '__main__':
    run(VelocityPublisherTest)
