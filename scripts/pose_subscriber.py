#!/usr/bin/env python3
"""Lesson 2, a subscriber: this node prints where the turtle is, whenever the simulator publishes it."""
import rospy
from turtlesim.msg import Pose

from turtle_robotont.params import check_params, number


def print_pose(pose):
    rospy.loginfo_throttle(period, 'Turtle pose: x:%0.6f, y:%0.6f', pose.x, pose.y)


rospy.init_node('pose_subscriber', anonymous=True)
check_params(rate=number(0.0, 1000.0, 'Hz'))
rate = rospy.get_param('~rate', 0.0)         # lines per second, at most [Hz]; 0: every pose
period = 1.0 / rate if rate > 0.0 else 0.0   # between two lines [s]
rospy.Subscriber('turtle1/pose', Pose, print_pose)
rospy.spin()
