#!/usr/bin/env python3
"""The simulated Robotont's topics, types, frames and rates with each model, by its launch files and in a namespace."""
import math

import rospy
import tf2_ros
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Image, JointState, LaserScan
from sim_ros.msg import ClockStatus

from rostest_support.common import median_rate, registered_names, run, until
from rostest_support.robotont import RobotontCase

ALWAYS = {'odom', '/tf', 'joint_states', '~ground_truth', '~world', '~clock_status', '/rosout'}
SERVICES = {'~set_pose', '~move_marker', '~pause', '~resume', '~step', '~set_rate', '~get_loggers', '~set_logger_level'}
GAZEBO_SERVICES = {f'gazebo/{name}' for name in (
    'set_model_state', 'get_model_state', 'get_world_properties', 'reset_world', 'reset_simulation', 'pause_physics',
    'unpause_physics')}
CAMERA = {'camera/color/image_raw', 'camera/color/camera_info', 'camera/depth/image_rect_raw',
          'camera/depth/camera_info', 'camera/depth/points', 'camera/aligned_depth_to_color/image_raw'}
RATE_TOLERANCE = 0.01  # of the rate: lateness of single messages weighs little over half a second
RATE_TIME = 4.0  # [s]


class InterfaceTest(RobotontCase):

    def full(self, names):
        return {name if name.startswith('/') else self.topic(name) for name in names}

    def assert_simulator(self, more=()):
        """Assert the registrations of the simulator's node."""
        self.message('odom', Odometry)
        self.assert_registered(self.topic('robotont_gazebo'), {*ALWAYS, 'gazebo/model_states', *more},
                               {'cmd_vel', 'gazebo/set_model_state'}, {*SERVICES, *GAZEBO_SERVICES})

    def assert_registered(self, node, *names):
        """Assert the names that a node publishes, subscribes to and serves, as far as given; it may still register."""
        expected = tuple(self.full(kind) for kind in names)
        until(lambda: all(map(set.issuperset, registered_names(node), expected)),
              lambda: f'{expected}; registered: {registered_names(node)}')
        self.assertEqual(expected, registered_names(node)[:len(expected)])

    def assert_frames(self, *frames):
        """Assert that a transform to each frame from odom can be had; frames without their prefix."""
        prefix = self.space[1:]
        buffer = tf2_ros.Buffer()
        listener = tf2_ros.TransformListener(buffer)
        self.addCleanup(listener.unregister)
        for frame in frames:
            until(lambda frame=frame: buffer.can_transform(f'{prefix}odom', prefix + frame, rospy.Time()),
                  lambda frame=frame: f'{prefix}{frame} among:\n{buffer.all_frames_as_yaml()}')
        return lambda target, source: buffer.lookup_transform(prefix + target, prefix + source,
                                                              rospy.Time()).transform

    def assert_rate(self, collected, rate):
        """Assert the rate of a topic by its messages' stamps, which a busy subscriber does not disturb."""
        start = len(collected.messages)
        stamps = [message.header.stamp.to_sec() for message in collected.some(start, round(rate * RATE_TIME) + 1)]
        self.assertAlmostEqual(rate, median_rate(stamps, span=round(rate / 2.0)), delta=rate * RATE_TOLERANCE)

    def test_robotont_lockstep_leaves_no_image_out(self):
        images = self.collected('camera/color/image_raw', Image)
        start = len(images.messages)
        stamps = [message.header.stamp.to_sec() for message in images.some(start, 31)]
        for earlier, later in zip(stamps, stamps[1:]):
            self.assertAlmostEqual(1.0 / 30.0, later - earlier, delta=1e-6)
        self.assertTrue(self.message('~clock_status', ClockStatus).lockstep)
        # it would never be idle: roscpp checks /clock a thousand times a second
        self.assertNotIn('/clock', registered_names('/robot_state_publisher')[1])

    def test_robotont_nuc(self):
        self.assert_simulator({'/clock'})
        self.assert_registered('/robotont_camera', {*CAMERA, '/rosout'},
                               {'/clock', '~ground_truth', '~world', '~moving_panels'})
        lookup = self.assert_frames('base_footprint', 'base_link', 'camera_link', 'rim_back_link', 'rim_left_link',
                                    'rim_right_link', 'camera_color_optical_frame', 'camera_depth_optical_frame')
        start = lookup('odom', 'base_footprint').translation
        self.assertEqual((-2.0, 0.0, 0.0), (start.x, start.y, start.z))
        camera = lookup('base_link', 'camera_color_optical_frame')
        self.assertAlmostEqual(-0.115, camera.translation.x, delta=1e-9)
        self.assertAlmostEqual(0.2025, camera.translation.z, delta=1e-9)
        rotation = camera.rotation  # z forward, x to the right: by -120 degrees about (1, -1, 1) / sqrt 3
        for value in (rotation.x, -rotation.y, rotation.z, -rotation.w):
            self.assertAlmostEqual(0.5, abs(value), delta=1e-6)

    def test_robotont_basic(self):
        self.assert_simulator()
        topics = [name for name, _ in rospy.get_published_topics()]
        self.assertEqual([], [name for name in topics if 'camera' in name or 'scan' in name])
        self.assert_frames('base_link', 'rim_back_link')
        odometry = self.collected('odom', Odometry)
        self.assertEqual(('odom', 'base_footprint'),
                         (odometry.messages[0].header.frame_id, odometry.messages[0].child_frame_id))
        self.assert_rate(odometry, 30.0)

    def test_robotont_joint_states(self):
        joints = self.collected('joint_states', JointState)
        self.drive_until(lambda: joints.messages[-1].position[0] > 10.0, 'a wheel that turns', 0.0, 0.0, 2.0)
        state = joints.messages[-1]
        self.assertEqual(['rim_back_joint', 'rim_right_joint', 'rim_left_joint'], state.name)
        for speed in state.velocity:  # turning on the spot: all wheels alike, at 2 rad/s * 0.146 m / 0.035 m
            self.assertAlmostEqual(2.0 * 0.146 / 0.035, speed, delta=1e-6)

    def test_robotont_lidar_in_namespace(self):
        self.space = '/colors/'
        self.assert_simulator({'scan'})
        lookup = self.assert_frames('base_footprint', 'base_link', 'hokuyo_link', 'rim_back_link')
        self.assertAlmostEqual(0.135, lookup('base_link', 'hokuyo_link').translation.z, delta=1e-9)
        odometry = self.message('odom', Odometry)
        self.assertEqual(('colors/odom', 'colors/base_footprint'), (odometry.header.frame_id, odometry.child_frame_id))
        self.assertEqual(['colors/rim_back_joint', 'colors/rim_right_joint', 'colors/rim_left_joint'],
                         self.message('joint_states', JointState).name)
        scans = self.collected('scan', LaserScan)
        scan = scans.messages[0]
        self.assertEqual('colors/hokuyo_link', scan.header.frame_id)
        self.assertEqual(720, len(scan.ranges))
        for value, field in ((-math.pi, 'angle_min'), (math.pi, 'angle_max'), (0.1, 'range_min'), (30.0, 'range_max'),
                             (0.025, 'scan_time')):
            self.assertAlmostEqual(value, getattr(scan, field), delta=1e-6, msg=field)
        # colors: the red cylinder is behind, its surface 1.922 m - 0.5 m - 0.01 m from the scanner; sigma is 0.01 m
        self.assertAlmostEqual(1.922 - 0.01 - 0.5, min(scan.ranges[:20]), delta=0.06)
        self.assertGreater(len(set(scan.ranges)), 100, 'there is no noise')
        self.assert_rate(scans, 40.0)

    def test_robotont_launch_files(self):
        starts = {'minimaze': -2.0, 'minimaze_ar': -2.0, 'bangbang': 0.0, 'between': -2.0, 'colors': 0.0}
        shapes = {'minimaze': (16, 0, 0), 'minimaze_ar': (16, 0, 5), 'bangbang': (1, 0, 0), 'between': (7, 0, 0),
                  'colors': (0, 6, 0)}
        for name, x in starts.items():
            self.space = f'/{name}/'
            self.assert_at(self.truth(), x, 0.0, 0.0)
            self.assert_at(self.odometry(), x, 0.0, 0.0)
            world = self.world()
            self.assertEqual(shapes[name], tuple(len(world[kind]) for kind in ('boxes', 'cylinders', 'panels')), name)
        self.space = '/elsewhere/'
        self.assert_at(self.truth(), 1.5, 0.0, 0.0)

    def test_robotont_camera_in_namespace(self):
        self.space = '/minimaze_ar/'
        info = self.message('camera/color/camera_info', CameraInfo)
        self.assertEqual('minimaze_ar/camera_depth_optical_frame', info.header.frame_id)
        self.assertEqual((640, 480), (info.width, info.height))
        self.assertAlmostEqual(320.0, info.K[0], delta=1e-6)


if __name__ == '__main__':
    run(InterfaceTest)
