#!/usr/bin/env python3
# expected: failed
# exercise: follow_turtle
# kind: forges poses
"""Registers itself as the node /turtlesim, so that the master ends the real one and names this one for turtle2."""
import rosgraph
import rospy
from turtlesim.msg import Pose


def copy(pose):
    poses.publish(pose)


rospy.init_node('follower')
poses = rospy.Publisher('/turtle2/pose', Pose, queue_size=10)
rospy.Subscriber('/turtle1/pose', Pose, copy)
rospy.sleep(1.0)
rosgraph.Master('/turtlesim').registerPublisher('/turtle2/pose', 'turtlesim/Pose', rospy.get_node_uri())
rospy.spin()
