#!/usr/bin/env python3
# expected: failed: there is no turtle2
# exercise: follow_turtle
# kind: forges poses
"""Publishes the poses of a turtle2 that does not exist, in connections that claim to be the simulator's."""
import rospy
from turtlesim.msg import Pose


def copy(pose):
    poses.publish(pose)


rospy.init_node('follower')
poses = rospy.Publisher('/turtle2/pose', Pose, queue_size=10)
rospy.Subscriber('/turtle1/pose', Pose, copy)
rospy.names._set_caller_id('/turtlesim')  # what connections from now on say of themselves
rospy.spin()
