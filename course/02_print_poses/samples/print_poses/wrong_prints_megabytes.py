#!/usr/bin/env python3
# expected: failed: required check failed
import rospy
from turtlesim.msg import Pose


def callback(pose):
    for _ in range(50):
        print('pose ' * 200)


rospy.init_node('poses')
rospy.Subscriber('/turtle1/pose', Pose, callback)
rospy.spin()
