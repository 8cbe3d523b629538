#!/usr/bin/env python3
import rospy
from turtlesim.msg import Pose


def print_pose(pose):
    rospy.loginfo('x: %.3f, y: %.3f', pose.x, pose.y)


rospy.init_node('pose_subscriber')
rospy.Subscriber('/turtle1/pose', Pose, print_pose)
rospy.spin()
