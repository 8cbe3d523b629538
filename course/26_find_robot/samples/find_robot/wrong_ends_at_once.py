#!/usr/bin/env python3
# expected: failed: ended too early
import rospy
from std_srvs.srv import Empty

rospy.init_node('find_robot')
rospy.wait_for_service('/global_localization')
find = rospy.ServiceProxy('/global_localization', Empty)
find()
