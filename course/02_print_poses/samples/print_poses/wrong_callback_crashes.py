#!/usr/bin/env python3
# expected: failed: 'Pose' object has no attribute 'position'
import rospy
from turtlesim.msg import Pose


def callback(pose):
    rospy.loginfo('x: %.6f, y: %.6f', pose.position.x, pose.position.y)


rospy.init_node('poses')
rospy.Subscriber('/turtle1/pose', Pose, callback)
rospy.spin()
