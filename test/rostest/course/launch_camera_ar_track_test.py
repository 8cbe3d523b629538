#!/usr/bin/env python3
"""camera_ar_track.launch on the rendered sequence whose truth is known."""
import glob
import json
import math
import os

from ar_track_alvar_msgs.msg import AlvarMarkers

from rostest_support.common import Collected, run, until
from rostest_support.robot import RobotCase

POSITION_TOLERANCE = 0.015  # of the distance: of a marker seen from the side
LAUNCH_DEADLINE = 90.0  # [s] the sequence lasts 7 and is rendered in 2


class LaunchCameraTest(RobotCase):

    def sequence(self):
        """Return the folder that the launch file had rendered."""
        pattern = os.path.join(os.environ['ROS_HOME'], 'turtle_robotont', 'marker_sequence_*', '')
        return until(lambda: glob.glob(pattern), pattern)[0]

    def test_launch_camera_ar_track(self):
        """Nothing said: the five markers of the sequence, and no other, where they are."""
        seen = Collected('ar_pose_marker', AlvarMarkers)
        until(lambda: {marker.id for message in seen.messages for marker in message.markers} >= {1, 2, 3, 4, 5},
              'all five markers', LAUNCH_DEADLINE)
        with open(os.path.join(self.sequence(), 'frames.json')) as file:
            frames = json.load(file)['frames']
        for message in seen.some(0, 20):
            self.assertEqual('camera_optical_frame', message.header.frame_id)
            self.assertTrue(any(shows(message, frame) for frame in frames), message)


def shows(message, frame):
    """Return whether the markers of a message are those of a frame, all of them, each where it is."""
    truth = {marker['id']: marker['position'] for marker in frame['markers']}
    needed = {marker['id'] for marker in frame['markers'] if not marker['ignore']}
    got = {marker.id: marker.pose.pose.position for marker in message.markers}
    return needed <= set(got) <= set(truth) and all(
        math.dist((p.x, p.y, p.z), truth[marker]) < POSITION_TOLERANCE * math.dist((0.0, 0.0, 0.0), truth[marker])
        for marker, p in got.items())


if __name__ == '__main__':
    run(LaunchCameraTest)
