#!/usr/bin/env python3
"""Poses of rendered markers: in the camera's frame, in other frames, as tf, as cubes."""
import re
import time

import numpy as np
import rospy
from geometry_msgs.msg import TransformStamped
from rosgraph_msgs.msg import Clock, Log
from tf2_msgs.msg import TFMessage
from tf2_ros import StaticTransformBroadcaster, TransformBroadcaster

from rostest_support.common import run, until
from rostest_support.markers import FRAME, PLACED, SIZE, TrackerCase

QUARTER = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])  # about z
SPEED = 1.0  # [m/s] of a camera that moves along x


def transform(parent, child, x, stamp):
    """The transform (x, 2, 3), turned by a quarter about z."""
    made = TransformStamped(child_frame_id=child)
    made.header.frame_id, made.header.stamp = parent, stamp
    made.transform.translation.x, made.transform.translation.y, made.transform.translation.z = x, 2.0, 3.0
    made.transform.rotation.z = made.transform.rotation.w = np.sqrt(0.5)
    return made


class PosesTest(TrackerCase):

    def test_ar_poses(self):
        """Poses, headers and confidence; tf and cubes beside them; an empty message when there is nothing."""
        poses, cubes, tf = self.collected(), self.cubes(), self.collected('/tf', TFMessage)
        camera = self.camera().show(*PLACED.values())
        self.assert_poses(self.next_with(poses, *PLACED))
        until(lambda: tf.messages and len(cubes.messages) >= 3, 'tf and cubes')
        for sent in tf.messages[-1].transforms:
            marker = PLACED[int(sent.child_frame_id[len('ar_marker_'):])]
            self.assertEqual(FRAME, sent.header.frame_id)
            self.assert_pose(sent.transform, marker.rotation, marker.position)
        self.assertEqual(len(PLACED), len(tf.messages[-1].transforms))
        self.assertEqual(set(PLACED), {cube.id for cube in cubes.messages})
        for cube in cubes.messages[:3]:
            marker = PLACED[cube.id]
            self.assertEqual((FRAME, 'basic_shapes', cube.CUBE), (cube.header.frame_id, cube.ns, cube.type))
            self.assertAlmostEqual(SIZE, cube.scale.x)
            self.assert_pose(cube.pose, marker.rotation, marker.position)
        camera.show()
        self.assertEqual(FRAME, self.next_with(poses).header.frame_id)

    def test_ar_poses_of_a_moving_camera(self):
        """tf comes at 20 Hz, after the pictures: each pose is that of the picture's stamp all the same."""
        broadcaster = TransformBroadcaster()
        begun = rospy.Time.now()
        timer = rospy.Timer(rospy.Duration(0.05), lambda event: broadcaster.sendTransform(transform(
            'map', 'eye', SPEED * (event.current_real - begun).to_sec(), event.current_real)))
        self.addCleanup(timer.shutdown)
        poses = self.collected()
        self.camera(frame='eye').show(*PLACED.values())
        start = poses.index(lambda message: len(message.markers) == 3, 'markers')
        for message in poses.some(start, 5):
            along = SPEED * (message.header.stamp - begun).to_sec()
            self.assert_poses(message, PLACED, (QUARTER, np.array([along, 2.0, 3.0])), 'map')

    def test_ar_time_jumps_back(self):
        """A recording that begins anew: tf from before is forgotten, or the older transforms would not be taken."""
        broadcaster, poses, camera = TransformBroadcaster(), self.collected(), self.camera(frame='recorder')
        for x, seconds in ((5.0, 1000.0), (7.0, 100.0)):
            camera.clock = lambda seconds=seconds: rospy.Time(seconds)
            camera.show(*PLACED.values())

            def known(x=x, seconds=seconds):
                broadcaster.sendTransform(transform('map', 'recorder', x, rospy.Time(seconds)))
                return poses.messages and poses.messages[-1].markers and poses.messages[-1].header.stamp.secs == seconds
            until(known, f'poses of the time {seconds}')
            self.assert_poses(poses.messages[-1], PLACED, (QUARTER, np.array([x, 2.0, 3.0])), 'map')

    def test_ar_simulated_time(self):
        """max_frequency counts in ROS time: at ten times real time 2 Hz are every picture of a camera's 20."""
        poses, camera = self.collected(), self.camera().show(*PLACED.values())
        clock, begun = rospy.Publisher('/clock', Clock, queue_size=1), time.monotonic()

        def enough():
            clock.publish(rospy.Time.from_sec(100.0 + 10.0 * (time.monotonic() - begun)))
            return len(poses.messages) > 15
        until(enough, 'poses')
        stamps = [message.header.stamp.to_sec() for message in poses.messages[5:]]
        self.assertLess(np.median(np.diff(stamps)), 2.5)  # [s]; by wall time 5
        camera.stop()

    def test_ar_missing_transform(self):
        """A frame that does not exist: empty messages and one warning with those that do; poses as soon as it does."""
        broadcaster = StaticTransformBroadcaster()
        broadcaster.sendTransform(transform('odom', 'base', 1.0, rospy.Time.now()))
        poses, log, tf = self.collected(), self.log(), self.collected('/tf', TFMessage)
        self.camera(frame=f'/{FRAME}').show(*PLACED.values())  # as for tf; tf2 takes no leading /
        log.wait(Log.WARN, r"no transform from the camera's frame camera to map: .* exist: base, (camera, )?odom")
        self.assertEqual([], poses.next().markers)
        until(lambda: tf.messages, 'tf of the markers, which needs no other frame')
        missing = self.status(lambda status: 'no transform' in status.message, 'a report on the missing transform')
        self.assertGreaterEqual(int(missing['markers without transform']), 3)
        broadcaster.sendTransform(transform('map', FRAME, 1.0, rospy.Time.now()))
        self.assert_poses(self.next_with(poses, *PLACED), PLACED, (QUARTER, np.array([1.0, 2.0, 3.0])), 'map')
        # one more at most, from before the tracker knew a frame
        self.assertEqual(1, len([text for text in log.texts(Log.WARN) if re.match('no transform.*exist: base', text)]))



if __name__ == '__main__':
    run(PosesTest)
