#!/usr/bin/env python3
import math

import rospy
from geometry_msgs.msg import Twist
from robotont_laserscan_to_distance.msg import LaserScanSplit

GOAL = 0.5  # [m]
GAIN = 0.5  # [1/s]: m/s for each m of error


def control(distances):
    velocity = Twist()
    # solution
    if not math.isnan(distances.center_min):
        velocity.linear.x = GAIN * (distances.center_min - GOAL)
    # end of solution
    publisher.publish(velocity)


rospy.init_node('p_controller')
publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
rospy.Subscriber('/scan_to_distance', LaserScanSplit, control)
rospy.spin()
