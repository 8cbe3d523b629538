#!/usr/bin/env python3
"""usb_cam_node from outside: images of folders and videos, calibrations, services, and errors."""
import os
import re
import signal

import cv2
import numpy as np
import roslib.packages
import rospy
import yaml
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from sensor_msgs.srv import SetCameraInfo
from std_srvs.srv import Empty

from rostest_support.common import Collected, Process, SimulatorCase, nightly, proxy, registered_names, run

NODE = (roslib.packages.find_node('usb_cam', 'usb_cam_node') or [None])[0]
WIDTH, HEIGHT = 64, 48  # [px]
K = [601.5, 0.0, 30.25, 0.0, 602.5, 20.75, 0.0, 0.0, 1.0]
LOSSY = 6  # error of a colour value after compression
RATE = 20.0  # [Hz] of most folders and videos here
SLOW = 8.0  # [Hz] where each picture counts: a subscriber on a busy machine must not lose one
GRID_TOLERANCE = 0.1  # [periods] with a drift of 5 % in each period it would be 0.2


def plain(red, width=WIDTH, height=HEIGHT):
    """Return an image of one colour with this red, no green and 99 blue; BGR."""
    return np.full((height, width, 3), (99, 0, red), np.uint8)


def reds(messages):
    """Return the red of Images."""
    return [image.data[0] for image in messages]


def calibration(width=WIDTH, **changes):
    """Return a calibration file's content."""
    document = {'image_width': width, 'image_height': HEIGHT, 'camera_name': 'head_camera',
                'camera_matrix': {'rows': 3, 'cols': 3, 'data': K}, 'distortion_model': 'plumb_bob',
                'distortion_coefficients': {'rows': 1, 'cols': 5, 'data': [0.1, 0.2, 0.3, 0.4, 0.5]},
                'rectification_matrix': {'rows': 3, 'cols': 3, 'data': [1, 0, 0, 0, 1, 0, 0, 0, 1]},
                'projection_matrix': {'rows': 3, 'cols': 4, 'data': [600, 0, 30, 0, 0, 600, 20, 0, 0, 0, 1, 0]}}
    return yaml.safe_dump({**document, **changes})


class UsbCamTest(SimulatorCase):

    def setUp(self):
        """Make a place for the input; no simulator is needed."""
        self.home = self.temporary_directory()
        self.folder = os.path.join(self.home, 'in')
        os.mkdir(self.folder)

    def put(self, name, content):
        """Write a picture (an array or its red) or a text into the folder; return its path."""
        path = os.path.join(self.folder, name)
        if isinstance(content, str):
            with open(path, 'w', encoding='utf-8') as file:
                file.write(content)
        else:
            self.assertTrue(cv2.imwrite(path, plain(content) if isinstance(content, int) else content))
        return path

    def video(self, number=5, name='v.avi'):
        """Write a video with the reds 20, 40, 60, ...; return its path."""
        path = os.path.join(self.folder, name)
        writer = cv2.VideoWriter(path, cv2.VideoWriter_fourcc(*'MJPG'), RATE, (WIDTH, HEIGHT))
        for value in range(number):
            writer.write(plain(20 * (value + 1)))
        writer.release()
        return path

    def start(self, device, *arguments, rate=RATE):
        """Start usb_cam_node on a device; return its Process when its services are there."""
        node = Process(NODE, f'_video_device:={device}', f'_rate:={rate}', *arguments, ROS_HOME=self.home)
        self.addCleanup(node.stop)
        rospy.wait_for_service('/usb_cam/stop_capture', 20.0)
        return node

    def images(self, topic='/usb_cam/image_raw', kind=Image):
        images = Collected(topic, kind)
        self.addCleanup(images.subscriber.unregister)
        return images

    def info(self, fits=lambda info: True):
        infos = self.images('/usb_cam/camera_info', CameraInfo)
        return infos.next(fits, 'the camera_info that is waited for')

    def assert_grid(self, stamps, rate):
        """Assert that stamps [s] come at a rate [Hz] and do not drift, but for single ones that are late."""
        self.assertAlmostEqual(rate, 1.0 / np.median(np.diff(stamps)), delta=0.1 * rate)
        periods = (stamps[:, None] - stamps) * rate  # from each to each
        self.assertLess(np.median(np.abs(periods - np.rint(periods)), axis=0).min(), GRID_TOLERANCE)

    def test_usb_cam_folder(self):
        """A folder in order and at its rate; image, camera_info and compressed belong together; names as always."""
        for name, red in (('f10.png', 30), ('f2.png', 20), ('f1.png', 10)):
            self.put(name, red)
        self.start(self.folder, '_camera_frame_id:=eye', '_horizontal_fov:=90', rate=SLOW)
        infos, compressed = self.images('/usb_cam/camera_info', CameraInfo), self.images(
            '/usb_cam/image_raw/compressed', CompressedImage)
        images = self.images().some(0, 17)
        found = reds(images)
        first = found.index(10)
        self.assertEqual([10, 20, 30] * 5, found[first:first + 15])
        image = images[first]
        self.assertEqual(('rgb8', WIDTH, HEIGHT, 3 * WIDTH, 0, bytes((10, 0, 99)) * (WIDTH * HEIGHT)),
                         (image.encoding, image.width, image.height, image.step, image.is_bigendian, image.data))
        self.assert_grid(np.array([each.header.stamp.to_sec() for each in images]), SLOW)
        matching = {info.header.stamp: info for info in infos.messages}
        paired = [(image, matching[image.header.stamp]) for image in images if image.header.stamp in matching]
        self.assertGreater(len(paired), 10)
        for image, info in paired:
            self.assertEqual(('eye', 'eye'), (image.header.frame_id, info.header.frame_id))
            # 90 degrees: f is half of the width
            self.assertEqual((WIDTH, HEIGHT, WIDTH / 2.0), (info.width, info.height, round(info.K[0], 6)))
        self.assertTrue({each.header.stamp for each in compressed.messages} & set(matching))
        jpeg = compressed.messages[-1]
        self.assertEqual('rgb8; jpeg compressed bgr8', jpeg.format)
        pixel = cv2.imdecode(np.frombuffer(jpeg.data, np.uint8), cv2.IMREAD_COLOR)[0, 0]
        self.assertTrue(abs(int(pixel[0]) - 99) <= LOSSY and pixel[2] <= 30 + LOSSY, pixel)
        published, _, services = registered_names('/usb_cam')
        self.assertEqual({'/usb_cam/image_raw', '/usb_cam/image_raw/compressed', '/usb_cam/camera_info', '/rosout'},
                         published)
        self.assertLessEqual({'/usb_cam/start_capture', '/usb_cam/stop_capture', '/usb_cam/set_camera_info'}, services)

    def test_usb_cam_video(self):
        """A video waits for its first subscriber, ends without loop, and start_capture plays it again."""
        node = self.start(self.video(), '_loop:=false', rate=SLOW)
        node.wait_for_output(f'at {WIDTH}x{HEIGHT} at {SLOW:g} Hz')
        images = self.images()
        for _ in range(2):
            found = reds(images.some(0, 5))
            self.assertTrue(np.allclose(found, (20, 40, 60, 80, 100), atol=LOSSY), found)
            node.wait_for_output('that was the last image, and ~loop is false')
            self.assertEqual(5, len(images.messages))
            images.messages.clear()
            proxy('/usb_cam/start_capture', Empty)()

    def test_usb_cam_calibration(self):
        """The folder's camera.yaml, refused while it is bad; another one by its URL, which has to fit the pictures."""
        self.put('a.png', 1)
        path = self.put('camera.yaml', calibration(image_height=-1))
        node = self.start(self.folder)
        node.wait_for_output(f'(?s){path}: image_height is -1; it must be .*Continuing without calibration')
        info = self.info()
        self.assertEqual((WIDTH, HEIGHT, {0.0}, ()), (info.width, info.height, set(info.K), info.D))
        self.put('camera.yaml', calibration())
        proxy('/usb_cam/stop_capture', Empty)()
        proxy('/usb_cam/start_capture', Empty)()
        info = self.info(lambda info: info.K[0])
        self.assertEqual((K, 'plumb_bob', (0.1, 0.2, 0.3, 0.4, 0.5), 600.0),
                         (list(info.K), info.distortion_model, info.D, info.P[0]))
        node.stop()
        other = self.put('other.yaml', calibration(width=80))
        node = self.start(self.folder, f'_camera_info_url:=file://{other}')
        self.assertEqual({0.0}, set(self.info().K))
        node.wait_for_output(f'The calibration {other} is for images of 80x48 .*; these are 64x48')

    @nightly
    def test_usb_cam_set_camera_info(self):
        """The new calibration is used at once, written, and read by the next node; nonsense changes nothing."""
        self.put('a.png', 1)
        node = self.start(self.folder, '_camera_name:=cam')
        path = os.path.join(self.home, 'camera_info', 'cam.yaml')
        node.wait_for_output(f'Camera calibration file {path} not found. Continuing without calibration')
        service = proxy('/usb_cam/set_camera_info', SetCameraInfo)
        info = CameraInfo(width=WIDTH, height=HEIGHT, distortion_model='plumb_bob', D=[0.1, 0.0, 0.0, 0.0, 0.0], K=K,
                          R=[1, 0, 0, 0, 1, 0, 0, 0, 1], P=[600, 0, 30, 0, 0, 600, 20, 0, 0, 0, 1, 0])
        answer = service(info)
        self.assertTrue(answer.success, answer.status_message)
        self.assertEqual(0.1, self.info(lambda info: list(info.K) == K).D[0])
        info.K = [float('nan'), *K[1:]]
        answer = service(info)
        self.assertFalse(answer.success)
        self.assertIn('camera_matrix is [nan', answer.status_message)
        self.assertEqual(K, list(self.info().K))
        node.stop()
        node = self.start(self.folder, '_camera_name:=cam')
        node.wait_for_output(f'camera calibration: {path}')
        self.assertEqual(K, list(self.info().K))

    @nightly
    def test_usb_cam_missing_device(self):
        """A device that is not there is named with those that are; the node lives and works when it is there."""
        path = os.path.join(self.folder, 'video7')
        node = self.start(path)
        node.wait_for_output(f'ERROR.*{path}: No such file or directory. '
                             '(No camera is connected|Available cameras: /dev/)')
        images = self.images()
        os.symlink(self.video(), path)
        images.more(2)
        self.assertEqual(1, len(re.findall('ERROR', node.output())), 'the same trouble is told once')
        node.stop()
        node = self.start('/dev/video987')
        node.wait_for_output('ERROR.*/dev/video987: No such file or directory. ')
        self.assertTrue(node.runs())

    def test_usb_cam_bad_input_recovers(self):
        """An empty folder, cut off pictures, another size, a folder that vanishes: named, and over when put right."""
        node = self.start(self.folder)
        node.wait_for_output(f'{self.folder} contains no images; their names end in')
        images = self.images()
        path = self.put('a.png', 1)
        images.more(2)
        with open(path, 'rb+') as file:
            file.truncate(40)
        node.wait_for_output(f'(?s){path} is skipped: .*{self.folder}: none of the 1 images can be read')
        other = self.put('b.png', plain(2, width=80))
        images.next(lambda image: image.width == 80, 'the other picture')
        self.assertEqual(1, node.output().count(f'{path} is skipped: '))
        self.put('a.png', 3)
        node.wait_for_output(f'{other} is skipped: it has 80x48 pixels, the first image 64x48')
        images.messages.clear()
        self.assertEqual({3}, set(reds(images.more(4))[1:]))
        os.rename(self.folder, f'{self.folder}2')
        node.wait_for_output(f'ERROR.*{self.folder}')
        os.rename(f'{self.folder}2', self.folder)
        images.more(2)

    @nightly
    def test_usb_cam_stopped_subscriber(self):
        """A subscriber that stops reading takes nothing from another one, nor from the services."""
        self.put('a.png', plain(1, 640, 480))
        self.start(self.folder)
        with Process('rostopic', 'hz', '/usb_cam/image_raw') as other:
            other.wait_for_output('average rate')
            other.process.send_signal(signal.SIGSTOP)
            try:
                images = self.images().some(0, int(3 * RATE))  # more than the buffers of its connection hold
                gaps = np.diff([image.header.stamp.to_sec() for image in images])
                self.assertLess(np.median(gaps), 1.5 / RATE)
                proxy('/usb_cam/stop_capture', Empty)()
            finally:
                other.process.send_signal(signal.SIGCONT)

    def test_usb_cam_launch(self):
        """The launch file with its own names: /usb_cam, and the frame usb_cam."""
        image = self.images().next()
        self.assertEqual('usb_cam', image.header.frame_id)
        self.assertEqual('yuyv', rospy.get_param('/usb_cam/pixel_format'))


if __name__ == '__main__':
    run(UsbCamTest)
