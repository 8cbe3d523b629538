#!/usr/bin/env python3
import rospy
from std_srvs.srv import Empty

rospy.init_node('background_by_parameters')
rospy.wait_for_service('/clear')
rospy.set_param('/turtlesim/background_r', 255)
rospy.set_param('/turtlesim/background_g', 255)
rospy.set_param('/turtlesim/background_b', 0)
clear = rospy.ServiceProxy('/clear', Empty)
clear()
rospy.loginfo('The background is yellow')
