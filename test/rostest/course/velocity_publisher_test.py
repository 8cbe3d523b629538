#!/usr/bin/env python3
"""velocity_publisher.py: its parameters, its topic, and its end."""

from geometry_msgs.msg import Twist, Vector3

from rostest_support.common import run
from rostest_support.course import CourseCase

RATE_TOLERANCE = 2.0  # [Hz] of 20


def twist(linear, angular):
    return Twist(Vector3(linear, 0.0, 0.0), Vector3(0.0, 0.0, angular))


class VelocityPublisherTest(CourseCase):

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


if __name__ == '__main__':
    run(VelocityPublisherTest)
