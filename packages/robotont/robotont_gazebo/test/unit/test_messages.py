"""sim_ros.robotont_messages, camera_topics, camera_node: the world's state in the fields of ROS messages."""
import math

import numpy as np
import pytest
import rospy
from geometry_msgs.msg import Pose as PoseMessage

from kinematic_core.worlds import camera, rays
from kinematic_core.worlds.frames import ahead, frames
from kinematic_core.worlds.planar import Pose2D, Twist2D
from robotont_gazebo import camera_node
from sim_ros import camera_topics
from sim_ros import robotont_messages as messages

STAMP = rospy.Time(12, 34)
POSE = Pose2D(1.0, -2.0, math.pi / 2.0)
HALF = math.sqrt(0.5)  # sin and cos of half of 90 degrees


def test_odometry():
    message = messages.odometry(STAMP, 'odom', 'base_footprint', POSE, Twist2D(0.1, 0.2, 0.3), (1e-5, 1e-3))
    assert (message.header.stamp, message.header.frame_id, message.child_frame_id) == (STAMP, 'odom', 'base_footprint')
    pose, twist = message.pose.pose, message.twist.twist
    assert (pose.position.x, pose.position.y, pose.position.z) == (1.0, -2.0, 0.0)
    assert (pose.orientation.x, pose.orientation.y) == (0.0, 0.0)
    assert (pose.orientation.z, pose.orientation.w) == pytest.approx((HALF, HALF))
    assert (twist.linear.x, twist.linear.y, twist.angular.z) == (0.1, 0.2, 0.3)
    variances = [1e-5, 1e-5, 1e12, 1e12, 1e12, 1e-3]
    assert np.reshape(message.pose.covariance, (6, 6)).tolist() == np.diag(variances).tolist()


def test_ground_truth_is_certain():
    message = messages.odometry(STAMP, 'world', 'base_footprint', POSE, Twist2D())
    assert set(message.pose.covariance) == {0.0}


@pytest.mark.parametrize('distance, noise, expected', [
    (10.0, 0.0, (1e-5, 1e-3)),
    (4.0, 0.05, (1e-5 + 0.01, 1e-3 + 0.01 / 0.146 ** 2)),  # 0.05 m after 1 m is 0.1 m after 4 m
])
def test_variances_grow_with_noise(distance, noise, expected):
    assert messages.odometry_variances(distance, noise) == pytest.approx(expected)


def test_transforms():
    base, *wheels = messages.transforms(STAMP, frames('r/'), POSE, (0.1, 0.2, 0.3)).transforms
    assert (base.header.stamp, base.header.frame_id, base.child_frame_id) == (STAMP, 'r/odom', 'r/base_footprint')
    assert (base.transform.translation.x, base.transform.translation.y) == (1.0, -2.0)
    assert base.transform.rotation.w == pytest.approx(HALF)
    assert [wheel.child_frame_id for wheel in wheels] == ['r/rim_back_link', 'r/rim_right_link', 'r/rim_left_link']
    assert {(wheel.header.stamp, wheel.header.frame_id) for wheel in wheels} == {(STAMP, 'r/base_link')}


def test_scan_is_the_facts_pages():
    scan = messages.laser_scan(STAMP, 'hokuyo_link', rays, np.full(720, 2.5))
    assert (scan.angle_min, scan.angle_max) == (-math.pi, math.pi)
    assert scan.angle_min + 719 * scan.angle_increment == pytest.approx(scan.angle_max)
    assert (scan.range_min, scan.range_max, scan.scan_time) == (0.10, 30.0, 0.025)
    assert scan.ranges == [2.5] * 720 and scan.header.frame_id == 'hokuyo_link'


@pytest.mark.parametrize('pose, distance, expected', [
    (Pose2D(1.0, 2.0, 0.0), 0.5, (1.5, 2.0)), (Pose2D(1.0, 2.0, math.pi / 2.0), -0.5, (1.0, 1.5)),
])
def test_ahead(pose, distance, expected):
    assert ahead(pose, distance) == pytest.approx(expected)


def test_camera_is_behind_the_middle_and_as_high_as_in_the_urdf():
    pose = PoseMessage()
    pose.position.x, pose.position.y = 1.0, 2.0
    pose.orientation.z, pose.orientation.w = HALF, HALF
    assert camera_node.camera_pose(pose) == pytest.approx((1.0, 2.0 - 0.115, 0.013 + 0.2025, math.pi / 2.0))


def test_camera_info_is_that_of_90_degrees():
    info = camera_topics.camera_info('c', camera.PinholeCamera(1280, 720))
    assert (info.width, info.height, info.header.frame_id, info.distortion_model) == (1280, 720, 'c', 'plumb_bob')
    assert list(info.K) == pytest.approx([640.0, 0.0, 640.0, 0.0, 640.0, 360.0, 0.0, 0.0, 1.0])
    assert list(info.P) == pytest.approx([640.0, 0.0, 640.0, 0.0, 0.0, 640.0, 360.0, 0.0, 0.0, 0.0, 1.0, 0.0])
    assert list(info.R) == np.eye(3).ravel().tolist() and list(info.D) == [0.0] * 5
