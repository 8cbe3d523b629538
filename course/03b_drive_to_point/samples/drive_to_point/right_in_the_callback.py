#!/usr/bin/env python3
import math

import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose

GOAL = (2.0, 8.0)


def drive(pose):
    dx, dy = GOAL[0] - pose.x, GOAL[1] - pose.y
    error = math.atan2(dy, dx) - pose.theta
    error = math.atan2(math.sin(error), math.cos(error))
    twist = Twist()
    if math.sqrt(dx ** 2 + dy ** 2) > 0.05:
        twist.angular.z = max(-1.5, min(1.5, 4.0 * error))
        twist.linear.x = min(2.0, math.hypot(dx, dy)) if abs(error) < 0.3 else 0.0
    publisher.publish(twist)


rospy.init_node('to_a_point')
publisher = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=10)
rospy.Subscriber('/turtle1/pose', Pose, drive)
rospy.spin()
