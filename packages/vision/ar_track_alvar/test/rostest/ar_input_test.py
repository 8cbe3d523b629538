#!/usr/bin/env python3
"""Input that is missing, wrong or changes: the tracker warns, keeps running, and works once the input is right."""
import copy

import numpy as np
import rospy
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import CompressedImage
from std_srvs.srv import Trigger

from alvar_core.camera import Camera
from rospy_support import images
from rostest_support.common import run, until
from rostest_support.markers import CAMERA, PLACED, TRACKER, TrackerCase, camera_info, picture, stays_away


class InputTest(TrackerCase):

    def test_ar_missing_input(self):
        """No image: the topics that there are instead are named. No camera_info: no poses, until it comes."""
        log, poses = self.log(), self.collected()
        other = self.camera(topic='/other/image_raw', info_topic='/other/camera_info').show(*PLACED.values())
        log.wait(Log.WARN, r'no image received for \d+ s\. /camera_image: no node publishes it\. Topics of type '
                 r'sensor_msgs/Image: /other/image_raw \(by .*\); remap with camera_image:=/other/image_raw')
        self.status(lambda status: status.level == status.WARN and 'no image' in status.message, 'a warning')
        other.stop()
        camera = self.camera().show(*PLACED.values())
        info, camera.info = camera.info, None
        log.wait(Log.WARN, r'no camera_info received for \d+ s\. /camera_info: .*')
        self.assertEqual([], poses.messages)
        answer = rospy.ServiceProxy(f'{TRACKER}/explain', Trigger)()
        self.assertEqual((False, 'There was no image to explain within 5 s: no camera_info came'),
                         (answer.success, answer.message))
        camera.info = info
        self.assert_poses(self.next_with(poses, *PLACED))

    def test_ar_bad_camera_info(self):
        """Refused with its reason, nothing is published; then all is well again."""
        camera, poses = self.camera().show(*PLACED.values()), self.collected()
        self.assert_poses(self.next_with(poses, *PLACED))
        log, good = self.log(), camera.info
        camera.info = copy.deepcopy(good)
        camera.info.width, camera.info.height = 320, 240
        reason = '/camera_info: the image has 640x480 pixels, camera_info is for 320x240'
        self.status(lambda status: status.message.startswith(reason), reason)
        self.assertTrue(stays_away(poses))
        log.wait(Log.WARN, f'{reason}.*')
        camera.info = good
        self.assert_poses(self.next_with(poses, *PLACED))

    def test_ar_camera_info_changes(self):
        """Twice the focal length: the same picture is of markers twice as far; a lens that bends; one not told."""
        camera, poses = self.camera().show(*PLACED.values()), self.collected()
        self.assert_poses(self.next_with(poses, *PLACED))
        zoomed = camera_info(Camera(CAMERA.matrix * [[2, 1, 1], [1, 2, 1], [1, 1, 1]]))
        camera.info = zoomed
        near = {m.id: m.pose.pose.position.z for m in poses.messages[-1].markers}
        far = poses.next(lambda message: len(message.markers) == 3 and all(
            m.pose.pose.position.z > 1.7 * near[m.id] for m in message.markers), 'markers twice as far')
        self.assertEqual(3, len(far.markers))
        bent = Camera(CAMERA.matrix, [-0.25, 0.06, 0.001, -0.001, 0.0])
        camera.show(*PLACED.values(), camera=bent)
        poses.next(lambda message: len(message.markers) == 3 and all(
            m.pose.pose.position.z < 1.2 * near[m.id] for m in message.markers), 'markers as near as before')
        self.assert_poses(self.next_with(poses, *PLACED))
        log, camera.info = self.log(), camera_info()  # not that of this lens
        log.wait(Log.WARN, r'The orientation of marker 3 is doubtful: .*K and D of camera_info.*')
        poses.next(lambda message: len(message.markers) == 3 and message.markers[0].confidence <= 50, 'a doubtful pose')

    def test_ar_encodings(self):
        """Colours and a Bayer pattern give the same poses; an unknown encoding is refused by name."""
        camera, poses = self.camera().show(*PLACED.values()), self.collected()
        grey = picture(*PLACED.values())
        for encoding, array in (('rgb8', np.repeat(grey[..., None], 3, 2)), ('bayer_rggb8', grey)):
            camera.image = images.to_image(array, encoding)
            until(lambda encoding=encoding: poses.more(2), encoding)
            self.assert_poses(self.next_with(poses, *PLACED))
        camera.image = images.to_image(grey)
        camera.image.encoding = 'rgb9'
        status = self.status(lambda status: "'rgb9'" in status.message, 'rgb9')
        self.assertRegex(status[''], "^/camera_image: encoding 'rgb9' is unknown; the known ones are: ")
        self.assertTrue(stays_away(poses))
        camera.image = images.to_image(grey)
        self.assert_poses(self.next_with(poses, *PLACED))

    def test_ar_compressed_and_rectified(self):
        """The topic below the remapped one; of a topic image_rect_color, P describes the images, D the raw ones."""
        self.tracker = '/compressed/compressed'
        poses = self.collected('compressed/ar_pose_marker')
        camera = self.camera(topic='compressed/cam/image_rect_color/compressed',
                             info_topic='compressed/camera_info', kind=CompressedImage).show(*PLACED.values())
        camera.info.D, camera.info.K = [-0.4, 0.1, 0.0, 0.0, 0.0], [2.0 * value for value in camera.info.K]
        self.assert_poses(self.next_with(poses, *PLACED))
        log = self.log()
        camera.image.data = camera.image.data[:-1000]
        log.wait(Log.WARN, '/compressed/cam/image_rect_color: a compressed image .* cannot be decoded: it is cut off')

    def test_ar_cut_off_pictures(self):
        """Too few bytes: refused and counted; then poses again."""
        camera, poses = self.camera().show(*PLACED.values()), self.collected()
        good = camera.image
        camera.image = copy.copy(good)
        camera.image.data = good.data[:1000]
        status = self.status(lambda status: 'has 1000 bytes of data, 307200 are needed' in status.message, 'a refusal')
        self.assertGreater(int(status['images refused']), 0)
        camera.image = good
        self.assert_poses(self.next_with(poses, *PLACED))

    def test_ar_camera_restarts(self):
        """The camera's node ends and another one begins, with another size of picture."""
        poses = self.collected()
        self.camera().show(*PLACED.values()).stop()
        begun = self.camera().show(*PLACED.values())
        self.assert_poses(self.next_with(poses, *PLACED))
        begun.stop()
        small = Camera([320, 0, 199.5, 0, 320, 149.5, 0, 0, 1])
        again = self.camera()
        again.image = images.to_image(picture(*PLACED.values(), camera=small, size=(400, 300)))
        again.info = camera_info(small, (400, 300))
        self.assert_poses(self.next_with(poses, *PLACED))


if __name__ == '__main__':
    run(InputTest)
