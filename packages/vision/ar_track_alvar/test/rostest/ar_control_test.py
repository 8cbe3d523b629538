#!/usr/bin/env python3
"""The tracker's interface, its switches, parameters and services."""

import dynamic_reconfigure.client
import numpy as np
import rospy
import rostopic
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger

from rospy_support import images
from rostest_support.common import registered_names, run, until
from rostest_support.markers import PLACED, TRACKER, TrackerCase, stays_away

PUBLISHED = {'/ar_pose_marker': 'ar_track_alvar_msgs/AlvarMarkers',
             '/visualization_marker': 'visualization_msgs/Marker', '/tf': 'tf2_msgs/TFMessage',
             '/tracker/parameter_updates': 'dynamic_reconfigure/Config',
             '/tracker/parameter_descriptions': 'dynamic_reconfigure/ConfigDescription'}
OURS = {'/diagnostics', '/tracker/debug_image', '/tracker/explained_image', '/rosout'}  # beside the original's
MD5 = {'AlvarMarker': 'ef2b6ad42bcb18e16b22fefb5c0fb85f', 'AlvarMarkers': '943fe17bfb0b4ea7890368d0b25ad0ad'}
DEFAULTS = {'enabled': True, 'max_frequency': 8.0, 'marker_size': 10.0, 'max_new_marker_error': 0.08,
            'max_track_error': 0.2}


class ControlTest(TrackerCase):
    def client(self):
        """Return a dynamic_reconfigure client of the tracker."""
        made = dynamic_reconfigure.client.Client(self.tracker, timeout=20)
        self.addCleanup(made.close)
        return made

    def test_ar_interface(self):
        """Names and types are the original's; the defaults are on the parameter server."""
        self.client()
        until(lambda: '/camera_image' in registered_names(TRACKER)[1], 'the subscription to pictures')
        published, subscribed, services = registered_names(TRACKER)
        self.assertEqual(set(PUBLISHED), published - OURS)
        self.assertEqual({'/camera_image', '/camera_info', '/tracker/enable_detection'}, subscribed)
        self.assertIn('/tracker/set_parameters', services)
        self.assertIn('/tracker/explain', services)
        for topic, name in PUBLISHED.items():
            self.assertEqual(name, rostopic.get_topic_type(topic)[0])
        from ar_track_alvar_msgs import msg
        self.assertEqual(MD5, {name: getattr(msg, name)._md5sum for name in MD5})
        for name, value in DEFAULTS.items():
            self.assertEqual(value, rospy.get_param(f'{TRACKER}/{name}'))

    def test_ar_enable(self):
        """Switched off by the topic or by dynamic_reconfigure it even leaves the picture's topic; both agree."""
        camera, poses, client = self.camera().show(*PLACED.values()), self.collected(), self.client()
        self.next_with(poses, *PLACED)
        enable = self.enabler()
        for switch in (enable, lambda on: client.update_configuration({'enabled': on})):
            switch(False)
            until(lambda: camera.images.get_num_connections() == 0, 'the end of the subscription')
            self.assertTrue(stays_away(poses))
            until(lambda: not client.get_configuration()['enabled'], 'the news at the clients')
            self.status(lambda status: status.message == 'disabled', 'disabled')
            switch(True)
            self.assert_poses(self.next_with(poses, *PLACED))

    def test_ar_reconfigure(self):
        """marker_size, the limits of the errors and the rate take effect at once; NaN is refused."""
        self.camera(rate=30.0).show(*PLACED.values())
        poses, client, log = self.collected(), self.client(), self.log()
        self.next_with(poses, *PLACED)
        client.update_configuration({'marker_size': 20.0})
        far = poses.next(lambda message: len(message.markers) == 3 and all(
            m.pose.pose.position.z > 0.9 for m in message.markers), 'markers twice as large, twice as far')
        for marker in far.markers:
            self.assert_pose(marker.pose.pose, PLACED[marker.id].rotation, 2 * PLACED[marker.id].position)
        self.assertEqual(20.0, client.update_configuration({'marker_size': float('nan')})['marker_size'])
        log.wait(Log.WARN, 'dynamic_reconfigure: marker_size is nan; it must be a finite number; it stays 20.0')
        self.assertEqual(0.1, client.update_configuration({'marker_size': -3.0})['marker_size'])
        client.update_configuration({'marker_size': 10.0, 'max_track_error': 0.0, 'max_new_marker_error': 0.0})
        self.next_with(poses)  # no corner fits without any error
        client.update_configuration({'max_track_error': 0.2, 'max_new_marker_error': 0.0})
        self.assertEqual([], poses.more(3)[-1].markers)
        client.update_configuration({'max_new_marker_error': 0.08, 'max_frequency': 25.0})
        self.assert_poses(self.next_with(poses, *PLACED))
        self.status(lambda status: float(status.values[0].value) > 15.0, 'more than 15 images per second')
        client.update_configuration({'max_frequency': 2.0})
        self.status(lambda status: float(status.values[0].value) < 4.0, 'at most 2 images per second')

    def test_ar_debug_image(self):
        """In colour, with a drawing on every marker, and only with a subscriber."""
        camera, poses = self.camera().show(*PLACED.values()), self.collected()
        self.next_with(poses, *PLACED)
        shown = self.collected(f'{TRACKER}/debug_image', Image)
        picture = images.bgr(shown.next()).astype(int)
        shown.subscriber.unregister()
        changed = np.abs(picture - images.grey(camera.image)[..., None].astype(int)).max(2) > 30
        for marker in poses.messages[-1].markers:
            place = marker.pose.pose.position
            x, y = (320 + 525 * place.x / place.z, 240 + 525 * place.y / place.z)
            self.assertGreater(changed[int(y) - 40:int(y) + 40, int(x) - 40:int(x) + 40].sum(), 200)
        self.assertLess(changed.sum(), 0.1 * changed.size)

    def test_ar_explain(self):
        """The service says what became of each candidate, and shows it."""
        explain = rospy.ServiceProxy(f'{TRACKER}/explain', Trigger)
        explain.wait_for_service(20)
        camera, poses = self.camera().show(*PLACED.values()), self.collected()
        self.next_with(poses, *PLACED)
        answer = explain()
        self.assertTrue(answer.success)
        for number in PLACED:
            self.assertIn(f'found as marker {number} (', answer.message)
        self.assertIn(f'Drawn in {TRACKER}/explained_image', answer.message)
        drawn = images.bgr(self.collected(f'{TRACKER}/explained_image', Image).next())
        self.assertGreater(len(drawn), len(images.grey(camera.image)))

    def test_ar_diagnostics(self):
        """Once a second: rate, times, markers."""
        self.camera(rate=30.0).show(*PLACED.values())
        values = self.status(lambda status: status.message.endswith('images per second')
                             and 6.0 < float(status.values[0].value) < 9.5, 'a rate of 8 Hz')
        self.assertEqual('3.00', values['markers per image'])
        self.assertLess(0.0, float(values['time per image [ms]']))
        self.assertLess(float(values['time per image [ms]']), float(values['time from image to message [ms]']) + 5.0)
        self.assertGreater(int(values['images beyond max_frequency']), 5)
        self.assertEqual('0', values['images refused'])




run(ControlTest)
