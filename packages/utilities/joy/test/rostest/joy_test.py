#!/usr/bin/env python3
"""joy_node: it waits for a device, and publishes what the device tells."""
import os
import subprocess
import tempfile
import unittest

import rospy
from sensor_msgs.msg import Joy

from joy.core.joystick import AXIS, BUTTON, EVENT, INITIAL
from rostest_support.common import run, until


class JoyTest(unittest.TestCase):

    def test_it_waits_for_a_joystick_and_publishes_its_changes(self):
        received = []
        subscriber = rospy.Subscriber('joy', Joy, received.append)
        with tempfile.TemporaryDirectory() as folder:
            device = os.path.join(folder, 'js0')
            node = subprocess.Popen(['rosrun', 'joy', 'joy_node', f'_dev:={device}'])
            try:
                until(subscriber.get_num_connections, 'the node publishes joy')
                os.mkfifo(device)
                writer = until(lambda: self.opened(device), 'the node has opened the device')
                os.write(writer, EVENT.pack(0, 0, AXIS | INITIAL, 1) + EVENT.pack(0, 1, BUTTON, 0))
                until(lambda: received, 'a message')
                self.assertEqual(((0.0, 0.0), (1,)), (received[-1].axes, received[-1].buttons))
                os.write(writer, EVENT.pack(0, -32767, AXIS, 1))
                until(lambda: len(received) > 1, 'a second message')
                self.assertEqual((0.0, 1.0), received[-1].axes)
                self.assertEqual(device, received[-1].header.frame_id)
            finally:
                node.terminate()
                node.wait()

    @staticmethod
    def opened(device):
        try:
            return os.open(device, os.O_WRONLY | os.O_NONBLOCK)
        except OSError:  # nobody reads yet
            return None


if __name__ == '__main__':
    run(JoyTest)
