#!/usr/bin/env python3
"""The images of the simulated Robotont's camera: positions of markers, depth, points; nothing without subscribers."""
import math

import numpy as np
from nav_msgs.msg import Odometry
from rosgraph import Master
from sensor_msgs.msg import CameraInfo, Image, PointCloud2

from alvar_core.camera import Camera
from alvar_core.detection.detector import Detector
from kinematic_core.worlds.camera import HEIGHT, WIDTH
from rostest_support.common import node_api, run, until
from rostest_support.robotont import RobotontCase, used

MARKER_SIZE = 0.28  # [m]
CAMERA_X, CAMERA_HEIGHT = -0.115, 0.2155  # [m] of the camera in base_footprint
SIZE, FOCAL = (WIDTH, HEIGHT), WIDTH / 2.0  # [px]
MIDDLE = HEIGHT // 2, WIDTH // 2  # row, column
LOW = MIDDLE[0] + round(0.53 * FOCAL)  # a row that sees the floor at 0.407 m, just beyond the blind zone
IDLE_SHARE = 0.2  # of a core: rendering 30 pictures a second takes more on any machine


class PicturesTest(RobotontCase):

    def face_marker_1(self):
        """Put the robot 1.4 m before marker 1's face, which is at y = 2.9; return the camera's distance [m]."""
        self.set_pose(-2.0, 1.5, math.pi / 2.0)
        return 2.9 - (1.5 + CAMERA_X)

    def pixels(self, message, kind, channels):
        return np.frombuffer(message.data, kind).reshape(message.height, message.width, channels)

    def markers(self, image, info):
        """Return what alvar_core finds in a picture."""
        return Detector(MARKER_SIZE).detect(self.pixels(image, np.uint8, 3)[..., ::-1], Camera(info.K, info.D))

    def test_robotont_camera_sees_a_marker_where_it_is(self):
        """The marker in the picture is found where the panel is."""
        distance = self.face_marker_1()
        truth = self.collected('~ground_truth', Odometry)
        info = self.message('camera/color/camera_info', CameraInfo)
        image = self.message('camera/color/image_raw', Image)
        self.assertEqual(('bgr8', *SIZE), (image.encoding, image.width, image.height))
        self.assertEqual(SIZE, (info.width, info.height))
        self.assertEqual('camera_depth_optical_frame', image.header.frame_id)
        until(lambda: image.header.stamp in [message.header.stamp for message in truth.messages],
              'the pose with the stamp of the picture')
        (marker,) = self.markers(image, info)
        self.assertEqual(1, marker.id)
        # the panel's middle is at z = 0.25: a little above the camera, so at y = -(0.25 - 0.2155); x = 0
        self.assertLess(np.linalg.norm(marker.position - [0.0, CAMERA_HEIGHT - 0.25, distance]), 0.01 * distance)

    def test_robotont_camera_follows_a_marker_that_moves(self):
        """A moved panel is seen in its new place."""
        self.face_marker_1()
        images = self.collected('camera/color/image_raw', Image)
        info = self.message('camera/color/camera_info', CameraInfo)
        self.move_marker('marker1', -2.2, 2.5, math.pi / 2.0)
        self.addCleanup(self.move_marker, 'marker1', -2.0, 2.9, math.pi / 2.0)
        target = [-0.2, CAMERA_HEIGHT - 0.25, 2.5 - 1.5 - CAMERA_X]  # 0.2 m to the left

        def there():
            return [marker for marker in self.markers(images.messages[-1], info)
                    if marker.id == 1 and np.linalg.norm(marker.position - target) < 0.01 * target[2]]
        until(there, 'a picture with the marker in its new place')

    def test_robotont_depth_and_points(self):
        """Depth picture and points show the distances of panel and floor."""
        distance = self.face_marker_1()
        depth = self.message('camera/depth/image_rect_raw', Image)
        self.assertEqual(('32FC1', *SIZE), (depth.encoding, depth.width, depth.height))
        pixels = self.pixels(depth, np.float32, 1)[..., 0]
        # the panel from z = 0.05 to 0.45 is before the camera; rows near the middle see it, those at the top the sky
        self.assertAlmostEqual(distance, float(pixels[MIDDLE]), delta=1e-4)
        self.assertTrue(np.isnan(pixels[0]).all())
        self.assertAlmostEqual(CAMERA_HEIGHT / ((LOW - MIDDLE[0]) / FOCAL), float(pixels[LOW, MIDDLE[1]]), delta=1e-3)
        self.assertTrue(np.isnan(pixels[-1]).all(), 'the floor at 0.384 m is in the blind zone')
        points = self.message('camera/depth/points', PointCloud2)
        cloud = self.pixels(points, np.float32, 4)
        self.assertEqual(SIZE, (points.width, points.height))
        self.assertEqual('camera_depth_optical_frame', points.header.frame_id)
        self.assertTrue(np.allclose(cloud[MIDDLE][:3], [0.0, 0.0, distance], atol=1e-4), cloud[MIDDLE])
        # the floor: below the camera by its height, wherever
        self.assertTrue(np.allclose(cloud[LOW, :, 1], CAMERA_HEIGHT, atol=1e-3))
        aligned = self.message('camera/aligned_depth_to_color/image_raw', Image)
        self.assertEqual(aligned.data, self.message('camera/depth/image_rect_raw', Image).data)

    def test_robotont_camera_rests_without_subscribers(self):
        """Without subscribers, nothing is rendered."""
        images = self.collected('camera/color/image_raw', Image)
        images.more(3)
        images.subscriber.unregister()
        pid = node_api('/robotont_camera').getPid(Master('/test').caller_id)[2]
        truth = self.collected('~ground_truth', Odometry)
        truth.more(10)
        begin = used(pid)
        truth.more(60)  # 2 s
        self.assertLess(used(pid) - begin, 2.0 * IDLE_SHARE)


if __name__ == '__main__':
    run(PicturesTest)
