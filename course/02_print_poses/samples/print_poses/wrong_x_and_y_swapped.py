#!/usr/bin/env python3
# expected: failed: lines with numbers are correct
import rospy
from turtlesim.msg import Pose


def callback(pose):
    rospy.loginfo('x: %.6f, y: %.6f', pose.y, pose.x)


rospy.init_node('poses')
rospy.Subscriber('/turtle1/pose', Pose, callback)
rospy.spin()
