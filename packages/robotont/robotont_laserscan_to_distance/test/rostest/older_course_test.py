#!/usr/bin/env python3
"""The older course's simulation: a robot that drives, and measures how far the box is."""
import unittest

import rospy
from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Odometry
from robotont_sensors.msg import LaserScanSplit

from rostest_support.common import Collected, run, until

BOX = 1.882  # [m] x of the box's face in bangbang
CAMERA = -0.115  # [m] of the robot
TOLERANCE = 0.02  # [m]
NEAR = 1.0  # [m] x at which the drive ends


class OlderCourseTest(unittest.TestCase):

    def test_distances_to_the_box_before_and_after_a_drive(self):
        """The first one is farther away than the floor in the lower half of the picture."""
        odometry = Collected('/robotont/odom', Odometry)
        split = Collected('/scan_to_distance', LaserScanSplit)
        publisher = rospy.Publisher('/robotont/cmd_vel', Twist, queue_size=1)

        def place():
            return odometry.messages[-1].pose.pose.position.x if odometry.messages else 0.0

        def measures():
            return split.messages and abs(split.messages[-1].centerMin - (BOX - place() - CAMERA)) < TOLERANCE

        def drives():
            publisher.publish(Vector3(0.5, 0.0, 0.0), Vector3())
            return place() > NEAR
        until(measures, lambda: f'{BOX - CAMERA} m: {split.messages[-1:]}')
        until(drives, lambda: f'a robot that drives; it is at {place()}')
        publisher.publish(Twist())
        until(measures, lambda: f'the box nearer, from {place()}: {split.messages[-1:]}')


if __name__ == '__main__':
    run(OlderCourseTest)
