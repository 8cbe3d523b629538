#!/usr/bin/env python3
"""Input that is missing, wrong or changes: the tracker warns, keeps running, and works once the input is right."""
import copy

import numpy as np
import rospy
from rosgraph_msgs.msg import Log
from std_srvs.srv import Trigger

from alvar_core.camera import Camera
from rospy_support import images
from rostest_support.common import run, until
from rostest_support.markers import CAMERA, PLACED, TRACKER, TrackerCase, camera_info, picture, stays_away

NAN = float('nan')


class InputTest(TrackerCase):

    def test_ar_no_picture(self):
        """It names the topic that it waits for, and those that there are instead."""
        log = self.log()
        self.camera(topic='/other/image_raw', info_topic='/other/camera_info').show(*PLACED.values())
        log.wait(Log.WARN, r'no image received for \d+ s\. /camera_image: no node publishes it\. Topics of type '
                 r'sensor_msgs/Image: /other/image_raw \(by .*\); remap with camera_image:=/other/image_raw')
        self.status(lambda status: status.level == status.WARN and 'no image' in status.message, 'a warning')

    def test_ar_no_camera_info(self):
        """Pictures alone: no poses, a warning that names the topic; poses as soon as there is a camera_info."""
        log, poses = self.log(), self.collected()
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
        """K of zeros, NaN, another size: each refused with its reason, nothing is published; then all is well again."""
        camera, poses = self.camera().show(*PLACED.values()), self.collected()
        self.assert_poses(self.next_with(poses, *PLACED))
        log, good = self.log(), camera.info
        zero, nan, small, unknown = (copy.deepcopy(good) for _ in range(4))
        zero.K, nan.K = [0.0] * 9, [NAN] * 9
        small.width, small.height = 320, 240
        unknown.distortion_model, unknown.D = 'pinhole', [0.1]
        for info, said in ((zero, 'K is .*0.0.* fx and fy must be above 0'), (nan, 'K is .*nan'),
                           (small, 'the image has 640x480 pixels, camera_info is for 320x240'),
                           (unknown, "distortion_model is 'pinhole'; known are: plumb_bob")):
            camera.info = info
            status = self.status(lambda status, said=said: said.split(' is ')[0].split('.*')[0] in status.message, said)
            self.assertRegex(status[''], f'^/camera_info: {said}')
            self.assertTrue(stays_away(poses), said)
            log.wait(Log.WARN, f'/camera_info: {said}.*')
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
        """Every kind of encoding gives the same poses; those that are none are refused by name."""
        camera, poses = self.camera().show(*PLACED.values()), self.collected()
        grey = picture(*PLACED.values())
        for encoding, array in (('rgb8', np.repeat(grey[..., None], 3, 2)), ('bgra8', np.repeat(grey[..., None], 4, 2)),
                                ('mono16', grey.astype(np.uint16) << 8), ('bayer_rggb8', grey),
                                ('yuv422', np.stack([np.full_like(grey, 128), grey], 2))):
            camera.image = images.to_image(array, encoding)
            until(lambda encoding=encoding: poses.more(2), encoding)
            self.assert_poses(self.next_with(poses, *PLACED))
        for encoding in ('32FC1', 'rgb9', ''):
            camera.image = images.to_image(grey)
            camera.image.encoding = encoding
            status = self.status(lambda status, name=encoding: f"'{name}'" in status.message, encoding)
            self.assertRegex(status[''], f"^/camera_image: encoding '{encoding}' is unknown; the known ones are: ")
            self.assertTrue(stays_away(poses), encoding)
        camera.image = images.to_image(grey)
        self.assert_poses(self.next_with(poses, *PLACED))

    def test_ar_cut_off_pictures(self):
        """Too few bytes, no pixels, a step that is too small: refused and counted; then poses again."""
        camera, poses = self.camera().show(*PLACED.values()), self.collected()
        good = camera.image
        for fields, said in (({'data': good.data[:1000]}, 'has 1000 bytes of data, 307200 are needed'),
                             ({'width': 0}, '0x480 pixels has no pixels'), ({'step': 5}, 'step is 5 bytes')):
            camera.image = copy.copy(good)
            for name, value in fields.items():
                setattr(camera.image, name, value)
            status = self.status(lambda status, said=said: said in status.message, said)
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
