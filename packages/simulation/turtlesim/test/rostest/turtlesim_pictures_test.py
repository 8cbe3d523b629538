#!/usr/bin/env python3
"""The simulator's picture: as topics for those who subscribe, as a file for those who ask."""
import contextlib
import os

import cv2
import numpy as np
import rospy
from sensor_msgs.msg import CompressedImage, Image

from rostest_support.common import (
    ARENA,
    BACKGROUND,
    DEADLINE,
    PEN,
    PIXELS_PER_METRE,
    Collected,
    SimulatorCase,
    node_api,
    run,
    until,
)

SIDE = 500  # [px]
SPRITE = 34  # [px] from a turtle's middle to the furthest that its sprite may reach
SPRITE_CENTRE_TOLERANCE = 8  # [px] a sprite need not be symmetrical: its head is longer than its tail
BUSY = 10  # times a second; pictures come 25 times, what else a thread does comes once
IMAGE = '/turtlesim/image_raw'
COMPRESSED = '/turtlesim/image_raw/compressed'


def array(image):
    """Return an Image message as (height, width, 3) uint8."""
    return np.frombuffer(image.data, np.uint8).reshape(image.height, image.width, 3)


def decode(png):
    """Return the bytes of a PNG file as (height, width, 3) uint8 RGB."""
    return cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)[:, :, ::-1]


def pixel(picture, x, y):
    """Return (r, g, b) at a place [m]."""
    return tuple(picture[round((ARENA - y) * PIXELS_PER_METRE), round(x * PIXELS_PER_METRE)])


def box(picture):
    """Return the centre (x, y) and the half size [px] of everything but the background in a picture."""
    rows, columns = np.nonzero((picture != BACKGROUND).any(axis=2))
    return ((columns.min() + columns.max()) / 2.0, (rows.min() + rows.max()) / 2.0,
            max(np.ptp(columns), np.ptp(rows)) / 2.0)


class PictureTest(SimulatorCase):

    def image(self):
        return rospy.wait_for_message(IMAGE, Image, DEADLINE)

    def connections(self):
        """Return the topics of the simulator that have connections."""
        return {link[4] for link in node_api('/turtlesim').getBusInfo('/test')[2] if link[2] == 'o'}

    def process_file(self, name):
        return f'/proc/{node_api("/turtlesim").getPid("/test")[2]}/{name}'

    def loads_opencv(self):
        with open(self.process_file('maps')) as maps:
            return 'cv2' in maps.read()

    def wakings(self):
        """Return how often each thread of the simulator has waited for something so far, by its id."""
        wakings, folder = {}, self.process_file('task')
        for thread in os.listdir(folder):
            with contextlib.suppress(OSError), open(f'{folder}/{thread}/status') as status:  # a thread may end
                wakings[thread] = int(next(line.split()[1] for line in status if line.startswith('voluntary')))
        return wakings

    def busy_threads(self, poses):
        """Return how many of the simulator's threads did something again and again in a second; the steps' is one."""
        before = self.wakings()
        poses.more(60)
        return sum(number - before.get(thread, number) >= BUSY for thread, number in self.wakings().items())

    def test_turtlesim_image(self):
        """Form of the message, and the turtle at its position on the background."""
        self.jump(2.0, 3.0)
        image = self.image()
        self.assertEqual(('rgb8', SIDE, SIDE, 3 * SIDE, 0, 3 * SIDE * SIDE),
                         (image.encoding, image.width, image.height, image.step, image.is_bigendian, len(image.data)))
        self.assertTrue(image.header.frame_id)
        self.assertLess(abs((rospy.Time.now() - image.header.stamp).to_sec()), DEADLINE)
        x, y, half = box(array(image))
        self.assertAlmostEqual(2.0 * PIXELS_PER_METRE, x, delta=SPRITE_CENTRE_TOLERANCE)
        self.assertAlmostEqual((ARENA - 3.0) * PIXELS_PER_METRE, y, delta=SPRITE_CENTRE_TOLERANCE)
        self.assertTrue(8 < half <= SPRITE, f'half the size of the sprite: {half} px')

    def test_turtlesim_image_shows_lines_and_turtles(self):
        """Lines are where they were drawn, and every turtle has a sprite of its own."""
        self.call('turtle1/set_pen', 255, 0, 0, 3, 0)
        self.call('turtle1/teleport_absolute', 1.0, 1.0, 0.0)
        self.jump(5.0, 10.0)
        self.assertEqual((255, 0, 0), pixel(array(self.image()), 3.0, 3.0))
        sprites = set()
        for name in ('anna', 'berta'):
            self.call('spawn', 9.0, 2.0, 0.0, name)
            self.call('clear')
            corner = array(self.image())[360:460, 350:460]
            sprites.add(corner.tobytes())
            self.assertTrue((corner != BACKGROUND).any(), f'no sprite of {name}')
            self.call('kill', name)
        self.assertEqual(2, len(sprites))

    def test_turtlesim_image_compressed(self):
        """The compressed picture is a PNG of the same pixels."""
        self.jump(2.0, 3.0)
        compressed = rospy.wait_for_message(COMPRESSED, CompressedImage, DEADLINE)
        self.assertIn('png', compressed.format)
        self.assertTrue(np.array_equal(array(self.image()), decode(compressed.data)))

    def test_turtlesim_image_only_for_subscribers(self):
        """No picture is made before the first subscriber nor after the last one; no connection stays."""
        poses = self.poses()
        idle = self.busy_threads(poses)
        self.assertFalse(self.loads_opencv(), 'OpenCV is loaded without anybody who wants a picture')
        for topic, kind in ((IMAGE, Image), (COMPRESSED, CompressedImage)):
            images = Collected(topic, kind)
            images.more(3)
            self.assertIn(topic, self.connections())
            self.assertGreater(self.busy_threads(poses), idle)
            images.subscriber.unregister()
            until(lambda: topic not in self.connections(), f'an end of the connection on {topic}')  # noqa: B023
            until(lambda: self.busy_threads(poses) <= idle, 'an end of making pictures')
        self.assertTrue(self.loads_opencv())

    def test_turtlesim_image_rate(self):
        """~image_rate sets how often images come; making them takes its time, too, so it is a little less."""
        self.assertAlmostEqual(9.0, Collected(IMAGE, Image).rate(20, 5), delta=3.0)

    def test_turtlesim_snapshot(self):
        """Saves the picture as a new PNG file and returns its path."""
        self.call('turtle1/teleport_absolute', 2.0, 3.0, 0.0)
        self.jump(8.0, 8.0)
        directory = self.temporary_directory()
        self.set_parameter('snapshot_dir', directory)
        answers = [self.call('snapshot') for _ in range(3)]
        self.assertEqual({True}, {answer.success for answer in answers})
        self.assertEqual(sorted(os.listdir(directory)), sorted(os.path.basename(answer.message) for answer in answers))
        for answer in answers:
            self.assertEqual(directory, os.path.dirname(answer.message))
            picture = cv2.imread(answer.message)[:, :, ::-1]
            self.assertEqual((SIDE, SIDE, 3), picture.shape)
            self.assertEqual(PEN, pixel(picture, 2.0, 3.0))
            self.assertTrue(np.array_equal(array(self.image()), picture))

    def test_turtlesim_snapshot_default_folder(self):
        """Without ~snapshot_dir the file goes to the simulator's working directory; its path is absolute."""
        answer = self.call('snapshot')
        self.assertTrue(answer.success, answer.message)
        self.addCleanup(os.remove, answer.message)
        self.assertTrue(os.path.isabs(answer.message))
        pid = node_api('/turtlesim').getPid('/test')[2]
        self.assertEqual(os.readlink(f'/proc/{pid}/cwd'), os.path.realpath(os.path.dirname(answer.message)))

    def test_turtlesim_snapshot_bad_folder(self):
        """A folder that cannot be written to, or is none: the answer names it and the parameter."""
        before = self.state()
        file = os.path.join(self.temporary_directory(), 'a_file')
        open(file, 'w').close()
        for directory in (file, '/does/not/exist'):
            self.set_parameter('snapshot_dir', directory)
            answer = self.call('snapshot')
            self.assertFalse(answer.success, directory)
            self.assertIn(directory, answer.message)
            self.assertIn('/turtlesim/snapshot_dir', answer.message)
        self.set_parameter('snapshot_dir', 7)
        self.assertRegex(self.refused('snapshot'), '/turtlesim/snapshot_dir is 7;')
        self.assert_unchanged(before)


if __name__ == '__main__':
    run(PictureTest)
