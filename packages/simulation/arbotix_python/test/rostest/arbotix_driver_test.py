#!/usr/bin/env python3
"""arbotix_driver: the robot without hardware drives, turns its joint, refuses NaN, and stops by itself."""
import unittest

import rospy
import tf2_ros
from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from rostest_support.common import run, until

OUT_OF_RANGE, LIMIT = 3.0, 1.0472  # [rad]; the range ends at 60 degrees


class ArbotixDriverTest(unittest.TestCase):

    def setUp(self):
        self.odometry = self.joints = None
        rospy.Subscriber('odom', Odometry, self.store_odometry)
        rospy.Subscriber('joint_states', JointState, self.store_joints)
        self.velocity = rospy.Publisher('cmd_vel', Twist, queue_size=1)
        until(lambda: self.odometry and self.joints and self.velocity.get_num_connections(), 'the node')

    def store_odometry(self, message):
        self.odometry = message

    def store_joints(self, message):
        self.joints = message

    def drive(self, speed):
        self.velocity.publish(Twist(linear=Vector3(x=speed)))
        return self.odometry.pose.pose.position.x

    def test_base_drives_and_stops_by_itself(self):
        until(lambda: self.drive(0.5) > 0.1, 'the base drives')
        until(lambda: self.odometry.twist.twist.linear.x == 0.0, 'the base stops')
        at = self.odometry.pose.pose.position.x
        self.velocity.publish(Twist(linear=Vector3(x=float('nan'))))
        seen = self.odometry.header.stamp
        until(lambda: self.odometry.header.stamp > seen + rospy.Duration(0.3), 'more odometry')
        self.assertEqual(at, self.odometry.pose.pose.position.x)
        buffer = tf2_ros.Buffer()
        tf2_ros.TransformListener(buffer)
        found = buffer.lookup_transform('odom', 'base_footprint', rospy.Time(0), rospy.Duration(60))
        self.assertEqual(at, found.transform.translation.x)

    def test_joint_goes_to_the_end_of_its_range(self):
        self.assertEqual(['head_pan_joint', 'base_l_wheel_joint', 'base_r_wheel_joint'], self.joints.name)
        head = rospy.Publisher('head_pan_joint/command', Float64, queue_size=1, latch=True)
        head.publish(OUT_OF_RANGE)
        until(lambda: abs(self.joints.position[0] - LIMIT) < 1e-3, 'the joint at 60 degrees')


if __name__ == '__main__':
    run(ArbotixDriverTest)
