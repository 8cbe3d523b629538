#!/usr/bin/env python3
# expected: failed: required check failed
import rospy
from std_srvs.srv import Empty

rospy.init_node('parameter_config')
rospy.wait_for_service('/clear')
rospy.set_param('/turtlesim/background_r', 255)
rospy.ServiceProxy('/clear', Empty)()
rospy.loginfo('done')
