#!/usr/bin/env python3
# expected: failed: required check failed
import rospy
from turtlesim.msg import Pose


def callback(pose):
    rospy.loginfo('x: %.6f, y: %.6f', pose.x, pose.y)


rospy.init_node('poses')
rospy.Subscriber('/turtle1/pose', Pose, callback)
