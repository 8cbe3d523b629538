#!/usr/bin/env python3
import rospy
from turtlesim.msg import Pose

last = None


def print_pose(pose):
    global last
    # solution
    if last is None or pose.x != last.x or pose.y != last.y:
        rospy.loginfo('x: %.3f, y: %.3f', pose.x, pose.y)
    last = pose
    # end of solution


rospy.init_node('print_poses')
# solution
rospy.Subscriber('/turtle1/pose', Pose, print_pose)
# end of solution
rospy.spin()
