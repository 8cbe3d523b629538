#!/usr/bin/env python3
# expected: failed: IoU
import rospy
from geometry_msgs.msg import Twist
from sensor_msgs.msg import LaserScan


def drive(scan):
    twist = Twist()
    twist.linear.x = 0.2
    twist.angular.z = 1.0
    publisher.publish(twist)


rospy.init_node('circles')
publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
rospy.Subscriber('/scan', LaserScan, drive, queue_size=1)
rospy.spin()
