#!/usr/bin/env python3
"""cv2's windows in programs as courses have them: image topics; keys, mouse and trackbars come from topics."""
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import unittest

import cv2
import numpy as np
import rospy
from geometry_msgs.msg import Point, Twist
from sensor_msgs.msg import Image
from std_msgs.msg import Int32, String

from rospy_support.images import pixels
from rostest_support.common import DEADLINE, run, until

PROGRAMS = pathlib.Path(__file__).resolve().parent / 'programs'
WIDTH, HEIGHT = 64, 48
LEFT, RIGHT = (0, 0, 200), (0, 200, 0)  # BGR: red with hue 0, green with hue 60


def camera_image():
    """Return an image whose left half is red, and whose right half is green."""
    image = np.empty((HEIGHT, WIDTH, 3), np.uint8)
    image[:, :WIDTH // 2], image[:, WIDTH // 2:] = LEFT, RIGHT
    return image


class Cv2WindowsTest(unittest.TestCase):

    def setUp(self):
        """Start a camera."""
        self.camera = rospy.Publisher('/camera/rgb/image_raw', Image, queue_size=1)
        message = Image(height=HEIGHT, width=WIDTH, encoding='bgr8', step=3 * WIDTH, data=camera_image().tobytes())
        timer = rospy.Timer(rospy.Duration(0.05), lambda _: self.camera.publish(message))
        self.addCleanup(self.camera.unregister)
        self.addCleanup(timer.shutdown)

    def start(self, name, *arguments, **environment):
        environment = {**os.environ, 'DISPLAY': '', 'PYTHONUNBUFFERED': '1', **environment}
        program = subprocess.Popen([sys.executable, str(PROGRAMS / name), *arguments], env=environment, text=True,
                                   stdout=subprocess.PIPE)
        self.addCleanup(program.stdout.close)
        self.addCleanup(program.kill)
        return program

    def listen(self, topic, kind):
        """Return the list to which the messages of a topic come."""
        got = []
        subscriber = rospy.Subscriber(topic, kind, got.append)
        self.addCleanup(subscriber.unregister)
        return got

    def send(self, topic, message):
        """Publish a message as soon as somebody listens."""
        publisher = rospy.Publisher(topic, type(message), queue_size=1)
        self.addCleanup(publisher.unregister)
        until(publisher.get_num_connections, f'a subscriber of {topic}')
        publisher.publish(message)

    def test_a_window_in_a_callback_is_a_topic_and_the_program_ends_with_its_node(self):
        window, velocities = self.listen('/cv_window/window', Image), self.listen('/cmd_vel', Twist)
        program = self.start('line_follower.py')
        until(lambda: len(window) > 3 and velocities, 'images of the window, and velocities')
        self.assertEqual(['bgr8', [0, 0, 255], list(RIGHT)], [
            window[-1].encoding, pixels(window[-1])[40, WIDTH // 2].tolist(), pixels(window[-1])[0, -1].tolist()])
        program.send_signal(signal.SIGINT)
        self.assertEqual(0, program.wait(DEADLINE))

    def test_trackbars_mouse_and_keys_reach_the_program(self):
        mask, trackbars = self.listen('/cv_window/mask', Image), self.listen('/cv_window/Track_Bars/trackbars', String)
        program = self.start('colour_tracker.py')
        until(lambda: mask and pixels(mask[-1]).tolist() == [[255] * WIDTH] * HEIGHT, 'a mask of everything')
        self.assertEqual('mono8', mask[-1].encoding)
        self.send('/cv_window/Track_Bars/trackbar/High_H', Int32(30))
        self.assertEqual('high 30\n', program.stdout.readline())
        until(lambda: pixels(mask[-1])[0].tolist() == [255] * (WIDTH // 2) + [0] * (WIDTH // 2), 'a mask of red')
        until(lambda: {'name': 'High H', 'value': 30, 'least': 0, 'most': 179} in json.loads(trackbars[-1].data),
              'the position of the trackbar')
        self.send('/cv_window/frame/mouse', Point(WIDTH - 1, 0, cv2.EVENT_LBUTTONDOWN))
        self.assertEqual(f'picked {list(RIGHT)} True frame\n', program.stdout.readline())
        self.send('/cv_window/frame/key', String('no key'))
        self.send('/cv_window/frame/key', String('q'))
        self.assertEqual(('ended by q\n', None), program.communicate(timeout=DEADLINE))

    def test_a_program_without_ros_shows_its_picture_and_waits_for_a_key(self):
        with tempfile.NamedTemporaryFile(suffix='.png') as file:
            cv2.imwrite(file.name, camera_image())
            program = self.start('read_picture.py', file.name)
            window = self.listen('/cv_window/Image', Image)
            until(lambda: window, 'the picture, for one who comes later')
        self.assertEqual(camera_image().tolist(), pixels(window[-1]).tolist())
        until(lambda: len(window) > 1, 'the picture again, without which a browser does not show it')
        self.assertIsNone(program.poll())
        self.send('/cv_window/Image/key', String('Escape'))
        self.assertEqual(('code 27\n', None), program.communicate(timeout=DEADLINE))
        self.assertEqual(0, program.returncode)


if __name__ == '__main__':
    run(Cv2WindowsTest)
