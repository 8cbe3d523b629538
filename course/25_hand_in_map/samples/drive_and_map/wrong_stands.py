#!/usr/bin/env python3
# expected: failed: IoU
import math

import rospy
from geometry_msgs.msg import Twist
from sensor_msgs.msg import LaserScan

DISTANCE = 0.6  # [m] from the wall at the left


def nearest(scan, low, high):
    """Return the smallest range [m] between two angles [degrees], 0 ahead, 90 to the left."""
    first = int((math.radians(low) - scan.angle_min) / scan.angle_increment)
    last = int((math.radians(high) - scan.angle_min) / scan.angle_increment)
    return min([value for value in scan.ranges[first:last] if value > scan.range_min] or [scan.range_max])


def drive(scan):
    twist = Twist()
    ahead = nearest(scan, -25, 25)
    left = nearest(scan, 30, 110)
    if ahead < DISTANCE:
        twist.angular.z = -1.0
    else:
        twist.angular.z = max(-1.0, min(1.0, 2.0 * (left - DISTANCE)))
    publisher.publish(twist)


rospy.init_node('left_wall')
publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
rospy.Subscriber('/scan', LaserScan, drive, queue_size=1)
rospy.spin()
