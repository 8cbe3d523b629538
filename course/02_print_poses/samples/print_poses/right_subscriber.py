#!/usr/bin/env python3
import rospy
from turtlesim.msg import Pose


def callback(pose):
    print(f'the turtle is at ({pose.x:.2f}, {pose.y:.2f})')


rospy.init_node('where_is_it')
rospy.Subscriber('/turtle1/pose', Pose, callback)
rospy.spin()
