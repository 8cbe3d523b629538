#!/usr/bin/env python3
"""Robots that spawn_model adds to one world: driving, frames, scans, images, and Gazebo's services."""
import math
import os
import subprocess
import tempfile
import unittest

import numpy as np
import rospy
import tf2_ros
from gazebo_msgs.msg import ModelState, ModelStates
from gazebo_msgs.srv import (
    DeleteModel,
    GetModelProperties,
    GetModelState,
    GetWorldProperties,
    SetModelState,
    SpawnModel,
)
from geometry_msgs.msg import Pose, Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image, JointState, LaserScan
from std_srvs.srv import Empty

from rospy_support.images import pixels
from rospy_support.rotations import to_quaternion
from rostest_support.common import proxy, run, until
from rostest_support.gazebo_robots import BOX, BURGER, CAMERA, with_extension

AHEAD = 2  # the ray of BURGER's laser that points ahead of the robot
FACE = 2.382 - 0.5  # [m] x of the face of the box in the world bangbang
TOLERANCE = 0.02  # [m]


def spawn(name, namespace, y, text):
    """Run spawn_model; return its CompletedProcess."""
    with tempfile.NamedTemporaryFile('w', suffix='.urdf', delete=False) as file:
        file.write(text)
    try:
        return subprocess.run(['rosrun', 'gazebo_ros', 'spawn_model', '-urdf', '-file', file.name, '-model', name, '-y',
                               str(y)], env=dict(os.environ, ROS_NAMESPACE=namespace), stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, timeout=60)
    finally:
        os.unlink(file.name)


def model_state(name, x, y, yaw=0.0):
    state = ModelState(model_name=name)
    state.pose.position.x, state.pose.position.y, state.pose.orientation = x, y, to_quaternion(0.0, 0.0, yaw)
    return state


class GazeboRosTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        for number, y in ((1, 0.0), (2, 1.5)):
            rospy.set_param(f'/robot{number}/tf_prefix', f'robot{number}')
            spawned = spawn(f'robot{number}', f'/robot{number}', y, with_extension(BURGER, CAMERA))
            assert spawned.returncode == 0, spawned.stdout
        cls.commands = rospy.Publisher('/robot1/cmd_vel', Twist, queue_size=1)
        cls.place = staticmethod(proxy('/gazebo/set_model_state', SetModelState))
        cls.buffer = tf2_ros.Buffer()
        cls.listener = tf2_ros.TransformListener(cls.buffer)
        until(lambda: cls.commands.get_num_connections(), 'gazebo listens to /robot1/cmd_vel')

    def setUp(self):
        proxy('/gazebo/reset_world', Empty)()

    def odometry(self, number=1):
        return rospy.wait_for_message(f'/robot{number}/odom', Odometry, 60)

    def front(self):
        return rospy.wait_for_message('/robot1/scan', LaserScan, 60).ranges[AHEAD]

    def test_a_robot_drives_on_after_one_command_until_the_box(self):
        command = Twist()
        command.linear.x = 0.5
        self.commands.publish(command)
        until(lambda: self.odometry().twist.twist.linear.x == 0.0 and self.odometry().pose.pose.position.x > 1.0,
              'the robot is at the box')
        self.assertAlmostEqual(FACE - 0.08, self.odometry().pose.pose.position.x, delta=TOLERANCE)
        turned = rospy.wait_for_message('/robot1/joint_states', JointState, 60)
        self.assertEqual(['left_joint', 'right_joint'], turned.name)
        self.assertAlmostEqual((FACE - 0.08) / 0.033, turned.position[0], delta=1.0)
        self.assertEqual(0.0, self.odometry(2).pose.pose.position.x)

    def test_frames_have_the_prefix_of_their_namespace(self):
        for number, y in ((1, 0.0), (2, 1.5)):
            odometry = self.odometry(number)
            self.assertEqual((f'robot{number}/odom', f'robot{number}/base_footprint'),
                             (odometry.header.frame_id, odometry.child_frame_id))
            found = self.buffer.lookup_transform(f'robot{number}/odom', f'robot{number}/base_footprint', rospy.Time(0),
                                                 rospy.Duration(60))
            self.assertAlmostEqual(y, found.transform.translation.y, delta=TOLERANCE)

    def test_lasers_see_the_world_and_the_other_robot(self):
        until(lambda: abs(self.front() - (FACE + 0.03)) < TOLERANCE, 'the laser sees the box')
        self.assertTrue(self.place(model_state('robot2', 1.0, 0.0)).success)
        until(lambda: abs(self.front() - (1.0 - 0.08 + 0.03)) < TOLERANCE, 'the laser sees the other robot')
        scan = rospy.wait_for_message('/robot1/scan', LaserScan, 60)
        self.assertEqual(('robot1/base_scan', 4), (scan.header.frame_id, len(scan.ranges)))

    def test_each_robot_has_images_of_its_own(self):
        images = {number: rospy.wait_for_message(f'/robot{number}/front/image_raw', Image, 60) for number in (1, 2)}
        self.assertEqual((64, 48, 'rgb8', 'robot2/eye_link'),
                         (images[2].width, images[2].height, images[2].encoding, images[2].header.frame_id))
        # the cameras look back, where nothing is; turned round, the first one sees the grey box in the middle
        self.place(model_state('robot1', 0.0, 0.0, math.pi))
        self.place(model_state('robot2', 0.0, 1.5, math.pi / 2.0))

        def differ():
            middles = [pixels(rospy.wait_for_message(f'/robot{number}/front/image_raw', Image, 60))[18:22, 30:34]
                       for number in (1, 2)]
            return np.abs(middles[0].astype(int) - middles[1]).mean() > 10
        until(differ, 'the images differ')

    def test_models_are_spawned_found_and_deleted(self):
        pose = Pose()
        pose.position.x, pose.position.y, pose.position.z = 0.0, -2.0, 0.3
        answer = proxy('/gazebo/spawn_sdf_model', SpawnModel)('crate', BOX, '', pose, 'world')
        self.assertTrue(answer.success, answer.status_message)
        until(lambda: 'crate' in rospy.wait_for_message('/gazebo/model_states', ModelStates, 60).name, 'crate is there')
        self.assertIn('crate', proxy('/gazebo/get_world_properties', GetWorldProperties)().model_names)
        self.assertEqual(['link'], proxy('/gazebo/get_model_properties', GetModelProperties)('crate').body_names)
        found = proxy('/gazebo/get_model_state', GetModelState)('crate', 'robot1')
        self.assertAlmostEqual(-2.0, found.pose.position.y)
        self.assertTrue(proxy('/gazebo/delete_model', DeleteModel)('crate').success)
        self.assertFalse(proxy('/gazebo/get_model_state', GetModelState)('crate', '').success)

    def test_a_deleted_robot_has_no_topics(self):
        self.assertEqual(0, spawn('robot3', '/robot3', -1.5, BURGER).returncode)
        self.odometry(3)
        self.assertTrue(proxy('/gazebo/delete_model', DeleteModel)('robot3').success)
        until(lambda: '/robot3/odom' not in dict(rospy.get_published_topics()), 'the topics are gone')

    def test_what_is_wrong_is_said(self):
        spawned = spawn('robot1', '/robot1', 0.0, BURGER)
        self.assertEqual(1, spawned.returncode)
        self.assertIn("there is a model 'robot1' already", spawned.stdout)
        self.assertIn("there is no model 'nobody'", self.place(model_state('nobody', 0.0, 0.0)).status_message)


if __name__ == '__main__':
    run(GazeboRosTest)
