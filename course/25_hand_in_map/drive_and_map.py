#!/usr/bin/env python3
import rospy
from geometry_msgs.msg import Twist
from sensor_msgs.msg import LaserScan

DISTANCE = 0.6  # [m] from the wall at the right


def drive(scan):
    velocity = Twist()
    # solution
    ahead = min(scan.ranges[310:410])
    right = min(scan.ranges[180:300])
    if ahead < DISTANCE:
        velocity.angular.z = 1.0
    else:
        velocity.linear.x = 0.4
        velocity.angular.z = max(-0.6, min(0.6, 2.0 * (DISTANCE - right)))
    # end of solution
    publisher.publish(velocity)


rospy.init_node('drive_and_map')
publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
rospy.Subscriber('/scan', LaserScan, drive)
rospy.spin()
