#!/usr/bin/env python3
"""velocity_publisher.py publishes a velocity ten times a second; at Ctrl-C the turtle stops."""
import statistics
import time

import rospy
from geometry_msgs.msg import Twist

from lesson_case import LessonCase, run

PERIOD, PERIOD_TOLERANCE = 0.1, 0.02  # [s]


class LessonPublisher(LessonCase):

    def test_publishes_at_its_rate_and_stops(self):
        """The median of the times between two messages, because a loaded machine delays some."""
        times = []
        rospy.Subscriber('turtle1/cmd_vel', Twist, lambda _: times.append(time.monotonic()), tcp_nodelay=True)
        program = self.start('velocity_publisher.py')
        self.until(lambda: len(times) > 30, '30 commands')
        self.assertAlmostEqual(PERIOD, statistics.median(b - a for a, b in zip(times, times[1:])),
                               delta=PERIOD_TOLERANCE)
        self.assertEqual({(0.5, 0.2)}, {(twist.linear.x, twist.angular.z) for twist in self.commands[:30]})
        self.until(lambda: abs(self.poses[-1].linear_velocity - 0.5) < 1e-3, 'the turtle driving')
        program.ctrl_c()
        self.until_ended(program)
        self.until_the_turtle_stands()
        self.assertEqual(Twist(), self.commands[-1])

    def test_parameters(self):
        """~linear and ~angular on the command line, and a topic remapped there."""
        self.spawn('anna')
        commands = self.record('anna/cmd_vel', Twist)
        self.start('velocity_publisher.py', '_linear:=-1.0', '_angular:=0.5', 'turtle1/cmd_vel:=anna/cmd_vel')
        self.until(lambda: commands, 'a command')
        self.assertEqual((-1.0, 0.5), (commands[-1].linear.x, commands[-1].angular.z))
        self.assertEqual([], self.commands)


if __name__ == '__main__':
    run(LessonPublisher)
