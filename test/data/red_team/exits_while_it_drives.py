#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: ends early
"""Ends with success, without any clean-up, in the middle of the drive."""
import os

import rospy
from geometry_msgs.msg import Twist

rospy.init_node('short')
publisher = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=1)
rate = rospy.Rate(10)
for _ in range(10):
    message = Twist()
    message.linear.x = 1.0
    publisher.publish(message)
    rate.sleep()
os._exit(0)
