#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: controls time
"""Lets the simulator run by itself, so that the grader's steps are refused."""
import rospy
from std_srvs.srv import Trigger

rospy.init_node('free')
while not rospy.is_shutdown():
    rospy.ServiceProxy('/turtlesim/resume', Trigger)()
