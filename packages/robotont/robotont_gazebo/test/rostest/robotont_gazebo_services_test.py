#!/usr/bin/env python3
"""Gazebo's own services and topics, and the panel that moves by itself."""
import math
import os

import numpy as np
import roslib.packages
import rospy
from gazebo_msgs.msg import ModelState, ModelStates
from gazebo_msgs.srv import GetModelState, GetWorldProperties, SetModelState
from geometry_msgs.msg import PoseArray
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image
from std_srvs.srv import Empty

from robotont_gazebo.camera_node import camera_pose
from rospy_support.images import bgr
from rospy_support.rotations import to_quaternion, yaw_of
from rostest_support.common import proxy, run, until
from rostest_support.robotont import RobotontCase
from sim_scene import worlds
from sim_scene.renderer import Renderer

LARGEST_DIFFERENCE = 0.5  # of the mean of all pixels, 0 to 255: the panel one frame late makes it above 1


def model(name, x, y, yaw, frame=''):
    """Return a ModelState."""
    state = ModelState(model_name=name, reference_frame=frame)
    state.pose.position.x, state.pose.position.y, state.pose.orientation = x, y, to_quaternion(0.0, 0.0, yaw)
    return state


class GazeboServicesTest(RobotontCase):

    def setUp(self):
        self.reset = proxy('/gazebo/reset_world', Empty)
        self.reset()
        self.set_state = proxy('/gazebo/set_model_state', SetModelState)
        self.get_state = proxy('/gazebo/get_model_state', GetModelState)

    def test_the_robot_is_put_somewhere(self):
        answer = self.set_state(model('robotont', -2.5, -0.5, 1.0))
        self.assertTrue(answer.success, answer.status_message)
        self.assert_at(self.truth(), -2.5, -0.5, 1.0)
        found = self.get_state('robotont', 'world')
        self.assertTrue(found.success)
        self.assertAlmostEqual(1.0, yaw_of(found.pose.orientation))
        self.reset()
        self.assert_at(self.truth(), -2.0, 0.5, 0.0)

    def test_what_is_wrong_is_said(self):
        for state, said in ((model('nobody', 0, 0, 0), "there is no model 'nobody'"),
                            (model('wall1', 0, 0, 0), "'wall1' cannot be moved"),
                            (model('robotont', 0, 0, 0, 'nowhere'), "there is no frame 'nowhere'"),
                            (model('robotont', math.nan, 0, 0), 'nan')):
            answer = self.set_state(state)
            self.assertFalse(answer.success)
            self.assertIn(said, answer.status_message)
        self.assertIn("there is no model 'nobody'", self.get_state('nobody', '').status_message)
        self.assert_at(self.truth(), -2.0, 0.5, 0.0)

    def test_a_message_puts_the_robot_somewhere_too(self):
        publisher = rospy.Publisher('/gazebo/set_model_state', ModelState, queue_size=1)
        self.addCleanup(publisher.unregister)
        until(publisher.get_num_connections, 'a subscriber')
        publisher.publish(model('robotont', -2.5, 0.0, 0.0))
        until(lambda: abs(self.truth()[0] + 2.5) < 1e-6, 'the robot at its new pose')

    def test_all_models_are_published(self):
        states = self.message('gazebo/model_states', ModelStates)
        self.assertEqual(len(states.name), len(states.pose))
        self.assertEqual(len(states.name), len(states.twist))
        self.assertEqual(proxy('/gazebo/get_world_properties', GetWorldProperties)().model_names, states.name)
        self.assertAlmostEqual(-2.0, states.pose[states.name.index('robotont')].position.x)

    def test_a_pause_stops_the_world(self):
        properties = proxy('/gazebo/get_world_properties', GetWorldProperties)
        proxy('/gazebo/pause_physics', Empty)()
        self.addCleanup(proxy('/gazebo/unpause_physics', Empty))
        stopped = properties().sim_time
        self.set_state(model('robotont', -2.4, 0.0, 0.0))  # is answered in a pause
        self.assertEqual(stopped, properties().sim_time)
        proxy('/gazebo/unpause_physics', Empty)()
        until(lambda: properties().sim_time > stopped, 'time that continues')

    def test_the_camera_sees_the_moving_panel_where_it_is_at_that_time(self):
        moving = self.collected('~moving_panels', PoseArray)
        truth = self.collected('~ground_truth', Odometry)
        images = self.collected('camera/color/image_raw', Image)
        start = len(images.messages)
        until(lambda: len(images.messages) > start + 3, 'images')
        until(lambda: moving.messages[-1].header.stamp >= images.messages[start + 3].header.stamp, 'the panel')
        folder = os.path.join(roslib.packages.get_pkg_dir('robotont_gazebo'), 'worlds')
        plan, _ = worlds.load_world('minimaze_ar_moving', folder)
        for image in images.messages[start + 1:start + 4]:
            pose, = (found for message in moving.messages if message.header.stamp == image.header.stamp
                     for found in message.poses)
            robot, = (message.pose.pose for message in truth.messages if message.header.stamp == image.header.stamp)
            placed = plan.with_moved([(pose.position.x, pose.position.y, yaw_of(pose.orientation))])
            expected = Renderer(placed, image.width, image.height).render(camera_pose(robot))[..., ::-1]
            self.assertLess(np.abs(bgr(image).astype(float) - expected).mean(), LARGEST_DIFFERENCE)


if __name__ == '__main__':
    run(GazeboServicesTest)
