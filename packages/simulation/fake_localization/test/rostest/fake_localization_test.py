#!/usr/bin/env python3
"""fake_localization: the robot stands in the map where it is in the world, whatever its odometry says."""
import unittest

import rospy
import tf2_ros
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import Odometry

from kinematic_core.worlds.planar import Pose2D
from rospy_support.rotations import to_quaternion
from rostest_support.common import run, until
from sim_ros.robotont_messages import base_transform

TRUTH, ODOMETRY = Pose2D(3.0, 2.0, 0.0), Pose2D(0.5, 0.0, 0.0)
TOLERANCE = 1e-6  # [m]


class FakeLocalizationTest(unittest.TestCase):

    def setUp(self):
        self.buffer = tf2_ros.Buffer()
        self.listener = tf2_ros.TransformListener(self.buffer)
        self.broadcaster = tf2_ros.TransformBroadcaster()
        self.truth = rospy.Publisher('base_pose_ground_truth', Odometry, queue_size=1)
        self.estimates = []
        rospy.Subscriber('amcl_pose', PoseWithCovarianceStamped, self.estimates.append)

    def publish(self):
        """Publish odometry and truth of now; return the newest estimate (x, y) in the map."""
        now = rospy.Time.now()
        self.broadcaster.sendTransform(base_transform(now, 'odom', 'base_link', ODOMETRY))
        message = Odometry()
        message.header.stamp = now
        message.pose.pose.position.x, message.pose.pose.position.y = TRUTH.x, TRUTH.y
        message.pose.pose.orientation = to_quaternion(0.0, 0.0, TRUTH.yaw)
        self.truth.publish(message)
        position = self.estimates[-1].pose.pose.position if self.estimates else None
        return position and (round(position.x, 6), round(position.y, 6))

    def test_the_robot_is_where_it_is_in_the_map(self):
        """True x = 3 is x = 2 in the map; the odometry of 0.5 m puts its frame to 1.5 m."""
        until(lambda: self.publish() == (2.0, 2.0), 'the estimate')
        found = self.buffer.lookup_transform('map', 'odom', rospy.Time(0), rospy.Duration(60)).transform.translation
        self.assertAlmostEqual(1.5, found.x, delta=TOLERANCE)
        self.assertAlmostEqual(2.0, found.y, delta=TOLERANCE)
        initial = PoseWithCovarianceStamped()
        initial.header.frame_id = 'map'
        initial.pose.pose.position.x, initial.pose.pose.orientation.w = 7.0, 1.0
        user = rospy.Publisher('initialpose', PoseWithCovarianceStamped, queue_size=1, latch=True)
        user.publish(initial)
        until(lambda: self.publish() == (7.0, 0.0), 'the estimate at the pose of the user')


if __name__ == '__main__':
    run(FakeLocalizationTest)
