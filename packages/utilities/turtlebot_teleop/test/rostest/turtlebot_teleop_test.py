#!/usr/bin/env python3
"""turtlebot_teleop: the joystick drives while its button is held; the keyboard drives by the names of the package."""
import subprocess
import unittest

import rospy
from geometry_msgs.msg import Twist
from sensor_msgs.msg import Joy

from rostest_support.common import DEADLINE, run, until

RIGHT_HALF_FORWARDS = [-1.0, 0.5]  # axes
KEYBOARD = ['rosrun', 'turtlebot_teleop', 'turtlebot_teleop_key', '__name:=keys', 'keys/cmd_vel:=driven',
            '_scale_linear:=0.4']


class TurtlebotTeleopTest(unittest.TestCase):

    def setUp(self):
        self.commands = []
        self.joystick = rospy.Publisher('joy', Joy, queue_size=1)

    def last(self, axes, held):
        self.joystick.publish(Joy(axes=axes, buttons=[0, 0, 0, 0, held]))
        return (self.commands[-1].linear.x, self.commands[-1].angular.z) if self.commands else None

    def test_joystick_drives_while_the_button_is_held(self):
        rospy.Subscriber('cmd_vel', Twist, self.commands.append)
        until(lambda: self.last(RIGHT_HALF_FORWARDS, 1) == (0.25, -0.9), 'half speed, full turn to the right')
        until(lambda: self.last(RIGHT_HALF_FORWARDS, 0) == (0.0, 0.0), 'a stop')
        del self.commands[:]
        self.joystick.publish(Joy(axes=[], buttons=[]))  # a joystick with too few axes
        until(lambda: self.last(RIGHT_HALF_FORWARDS, 1) == (0.25, -0.9), 'it drives again')

    def test_keyboard_drives_on_its_private_topic_with_its_scale(self):
        rospy.Subscriber('driven', Twist, self.commands.append)
        with subprocess.Popen(KEYBOARD, stdin=subprocess.PIPE) as keyboard:
            try:
                keyboard.stdin.write(b'i')
                keyboard.stdin.flush()
                until(lambda: any(command.linear.x == 0.4 for command in self.commands), 'forwards at 0.4 m/s',
                      2.0 * DEADLINE)  # rosrun and two programs start one after the other
                keyboard.stdin.close()
                until(lambda: self.commands[-1] == Twist(), 'a stop when no more keys come')
            finally:
                keyboard.terminate()


if __name__ == '__main__':
    run(TurtlebotTeleopTest)
