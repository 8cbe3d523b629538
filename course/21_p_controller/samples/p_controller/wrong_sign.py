#!/usr/bin/env python3
# expected: failed: the distance ahead by
import math

import rospy
from geometry_msgs.msg import Twist
from robotont_laserscan_to_distance.msg import LaserScanSplit

GOAL = 0.5  # [m]
GAIN = 0.5  # [1/s]: m/s for each m of error


def control(distances):
    twist = Twist()
    if not math.isnan(distances.center_min):
        twist.linear.x = GAIN * (GOAL - distances.center_min)
    publisher.publish(twist)


rospy.init_node('p_controller')
publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
rospy.Subscriber('/scan_to_distance', LaserScanSplit, control)
rospy.spin()
