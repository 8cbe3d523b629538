#!/usr/bin/env python3
"""findMarkerBundlesNoKinect and trainMarkerBundle: poses, what rviz gets, moved markers, bad files."""
import os

import numpy as np
import roslib.packages
import rospy
from rosgraph_msgs.msg import Log
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

from alvar_core import bundles, rotations
from rostest_support.common import run, until
from rostest_support.marker_scenes import Placed
from rostest_support.markers import FRAME, TrackerCase

FOLDER = os.path.join(roslib.packages.get_pkg_dir('ar_track_alvar'), 'bundles')
BOARD, POST = (os.path.join(FOLDER, name) for name in ('board.xml', 'post.xml'))
ROTATION, POSITION = rotations.facing(0.5, 0.8, 0.3), np.array([-0.05, 0.03, 0.5])
BOX = {8: (np.eye(3), np.zeros(3)),  # id: rotation and position of its marker; three sides
       9: (rotations.matrix_from_rpy(0, 0.7, 0), np.array([0.07, 0.0, -0.02])),
       10: (rotations.matrix_from_rpy(-0.8, 0, 0.2), np.array([0.01, 0.06, -0.02]))}
LEARNT_POSITION, LEARNT_ANGLE = 0.001, np.radians(1.0)  # [m]
RED, GREEN = (1, 0, 0, 1), (0, 1, 0, 0.7)


def placed(path, *numbers, moved=None, rotation=ROTATION, position=POSITION):
    """Placed markers of a bundle file; ``moved`` is a centimetre and a half from where it belongs."""
    bundle = bundles.read(path)
    markers = []
    for number in numbers:
        turn, centre = bundles.marker_pose(bundle.corners[number])
        centre = centre + ([0.015, 0, 0] if number == moved else [0, 0, 0])
        markers.append(Placed(number, bundle.sizes[number], rotation @ turn, rotation @ centre + position))
    return markers


def rotation_of_box(number):
    """Return the rotation of the box in an image."""
    return rotations.facing(0.25 + 0.1 * (number % 3), 2.2 * number, 0.2 * number)


class BundleTest(TrackerCase):

    def test_ar_bundles(self):
        """One pose for each visible bundle, also without its master; other markers go to rviz; a moved one is named."""
        poses, cubes, tf, log = self.collected(), self.cubes(), self.collected('/tf', TFMessage), self.log()
        stranger = Placed(77, 0.044, ROTATION, POSITION + [-0.1, -0.1, 0])
        camera = self.camera().show(*placed(BOARD, 8, 9, 10, 11), stranger)
        self.assert_poses(self.next_with(poses, 8), {8: placed(BOARD, 8)[0]})
        until(lambda: tf.messages and len({(cube.ns, cube.id) for cube in cubes.messages}) == 5, 'tf and five cubes')
        self.assertEqual({'ar_marker_8'}, {t.child_frame_id for message in tf.messages for t in message.transforms})
        looks = {(cube.ns, cube.id): cube.color for cube in cubes.messages}
        self.assertEqual({('main_shapes', 8), *(('basic_shapes', n) for n in (9, 10, 11, 77))}, set(looks))
        for (space, _), colour in looks.items():
            self.assertEqual(RED if space == 'main_shapes' else GREEN,
                             tuple(round(part, 3) for part in (colour.r, colour.g, colour.b, colour.a)))
        camera.show(*placed(BOARD, 9, 10, 11, moved=10))
        log.wait(Log.WARN, 'Marker 10 is not where .*board.xml says .*')
        self.assert_poses(poses.next(), {8: placed(BOARD, 8)[0]})
        camera.show(stranger)
        self.assertEqual(FRAME, self.next_with(poses).header.frame_id)

    def test_ar_training(self):
        """pr2_train.launch: three sides of a box are learnt from images, one marker is missing; the file has it."""
        def ask(command):
            return rospy.ServiceProxy(f'/training/ar_track_alvar/{command}', Trigger)()
        rospy.wait_for_service('/training/ar_track_alvar/reset', 20.0)
        path = ask('load').message.split('bundle file ')[1].split(' cannot be read')[0]  # there is none yet
        self.addCleanup(lambda: os.path.exists(path) and os.unlink(path))
        self.assertIn('nothing is learnt', ask('save').message)
        self.assertIn('0 images are too few. Not seen in any image', ask('optimize').message)
        camera = self.camera(topic='/box/image', info_topic='/box/info')
        for number in range(8):
            rotation = rotation_of_box(number)
            camera.show(*(Placed(index, 0.05, rotation @ turn, rotation @ place + [0.02, 0.0, 0.4])
                          for index, (turn, place) in BOX.items()))
            answer = until(lambda: [each for each in [ask('capture')] if each.success], f'image {number}')[0]
        self.assertEqual('Image 8 is kept: markers 8, 9, 10. Not seen in any image, beside another marker of the '
                         'bundle: 30.', answer.message)
        self.assertRegex(ask('optimize').message, r'Learnt from 8 images(.*\n)*  marker 10: position \+-0\.\d\d mm')
        self.assertTrue(ask('save').success)
        bundle = bundles.read(path)
        self.assertEqual(((8, 9, 10, 30), 8), (bundle.ids, bundle.master))
        for index, (turn, place) in BOX.items():
            rotation, position = bundles.marker_pose(bundle.corners[index])
            self.assertLess(np.linalg.norm(position - place), LEARNT_POSITION, index)
            self.assertLess(rotations.angle_between(rotation, turn), LEARNT_ANGLE, index)
        poses = self.collected('/training/ar_pose_marker')
        self.assert_pose(self.next_with(poses, 8, 9, 10).markers[-1].pose.pose, rotation_of_box(7), [0.02, 0.0, 0.4])
        self.assertTrue(ask('reset').success and ask('load').success)
        with open(path, 'w', encoding='utf-8') as file:
            file.write('<multimarker markers="1">')
        self.assertIn('not XML', ask('load').message)


if __name__ == '__main__':
    run(BundleTest)
