#!/usr/bin/env python3
# expected: failed
# exercise: print_marker_ids
# kind: controls time
"""Stops the time of a grading in real time, so that it would never end."""
import time

import rospy
from std_srvs.srv import Trigger

rospy.init_node('pause')
time.sleep(0.1)  # the wall clock
try:
    rospy.ServiceProxy('/turtlesim/pause', Trigger)()
except rospy.ServiceException as error:
    print(error)
rospy.spin()
