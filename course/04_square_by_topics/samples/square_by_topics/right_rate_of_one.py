#!/usr/bin/env python3
# The sleep of the rate, one second at first, gives the publisher the time to connect.
import math

import rospy
from geometry_msgs.msg import Twist

SIDE = 3.0

rospy.init_node('square_in_steps')
steps = rospy.Rate(1)
velocity = rospy.Publisher('turtle1/cmd_vel', Twist, queue_size=1)
steps.sleep()
for step in range(8):
    twist = Twist()
    if step % 2 == 0:
        twist.linear.x = SIDE
    else:
        twist.angular.z = math.pi / 2
    velocity.publish(twist)
    steps.sleep()
    velocity.publish(Twist())
    steps.sleep()
