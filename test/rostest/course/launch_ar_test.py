#!/usr/bin/env python3
"""camera_ar_track.launch and ar_control.launch, started for real, on the rendered sequence whose truth is known."""
import glob
import json
import math
import os

import rosgraph
from ar_track_alvar_msgs.msg import AlvarMarkers
from nav_msgs.msg import Odometry

from rostest_support.common import Collected, Process, release, run, until
from rostest_support.robot import RobotCase

POSITION_TOLERANCE = 0.015  # of the distance: of a marker seen from the side
CORNER_TOLERANCE = 0.02  # [m]
LAUNCH_DEADLINE = 90.0  # [s] the sequence lasts 7 and is rendered in 2


class LaunchArTest(RobotCase):

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

    def test_launch_ar_control(self):
        """A folder of pictures, and a marker to follow: it is printed, and the robot told to go there."""
        folder, velocities = self.temporary_directory(), self.velocities()
        self.ended(self.start('marker_sequence.py', '--output', folder))
        launch = Process('roslaunch', 'turtle_robotont', 'ar_control.launch', f'source:={folder}', 'mode:=follow',
                         'marker_id:=5', 'distance:=0.3', 'speed:=0.1')
        self.addCleanup(launch.stop)
        launch.wait_for_output('Detected marker with ID 5', LAUNCH_DEADLINE)
        twist = velocities.next(lambda twist: twist.linear.x > 0.05, 'a robot told to go ahead')
        self.assertLess(twist.linear.x, 0.1 + 1e-9)
        self.assertLess(twist.angular.z, 0.0, 'the marker is to the right')

    @release
    def test_launch_drive_robot_shape(self):
        """The simulator with it, faster than real time: the robot passes the corners, and all ends by itself."""
        truth = Collected('/robotont_gazebo/ground_truth', Odometry)
        launch = Process('roslaunch', 'turtle_robotont', 'drive_robot_shape.launch', 'rate:=4', 'shape:=triangle',
                         'size:=0.4', 'strafe:=true', 'turn_speed:=0.5')
        self.addCleanup(launch.stop)
        self.assertIn('Drawn in', self.ended(launch, deadline=LAUNCH_DEADLINE))
        way = [(message.pose.pose.position.x, message.pose.pose.position.y) for message in truth.messages]
        self.assertEqual((-2.0, 0.0), way[0])
        for corner in ((-1.6, 0.0), (-1.8, 0.2 * math.sqrt(3.0)), (-2.0, 0.0)):
            near = [number for number, place in enumerate(way) if math.dist(place, corner) < CORNER_TOLERANCE]
            self.assertTrue(near, f'{corner} missed by {min(math.dist(place, corner) for place in way):.3f} m')
            way = way[near[0]:]
        self.assertLess(max(abs(message.pose.pose.orientation.z) for message in truth.messages), 0.02, 'no turning')

    def test_launch_ar_nodes(self):
        """source:=simulator brings no camera of its own and listens to the robot's."""
        wanted = ['/camera/color/image_raw', '/camera/color/camera_info']
        master = rosgraph.Master('/test')

        def subscribed():
            state = master.getSystemState()[1]
            return [topic for topic, nodes in state if '/ar_track_alvar' in nodes and topic in wanted]
        until(lambda: len(subscribed()) == 2, f'the tracker subscribed to {wanted}')
        nodes = {node for kind in master.getSystemState() for _, names in kind for node in names}
        self.assertNotIn('/usb_cam', nodes)


def shows(message, frame):
    """Return whether the markers of a message are those of a frame, all of them, each where it is."""
    truth = {marker['id']: marker['position'] for marker in frame['markers']}
    needed = {marker['id'] for marker in frame['markers'] if not marker['ignore']}
    got = {marker.id: marker.pose.pose.position for marker in message.markers}
    return needed <= set(got) <= set(truth) and all(
        math.dist((p.x, p.y, p.z), truth[marker]) < POSITION_TOLERANCE * math.dist((0.0, 0.0, 0.0), truth[marker])
        for marker, p in got.items())


if __name__ == '__main__':
    run(LaunchArTest)
