#!/usr/bin/env python3
import rospy
from std_srvs.srv import Empty

rospy.init_node('background_by_parameters')
red = rospy.get_param('~red', 255)
green = rospy.get_param('~green', 255)
blue = rospy.get_param('~blue', 0)
rospy.wait_for_service('/clear')
# solution
rospy.set_param('/turtlesim/background_r', red)
rospy.set_param('/turtlesim/background_g', green)
rospy.set_param('/turtlesim/background_b', blue)
clear = rospy.ServiceProxy('/clear', Empty)
clear()
# end of solution
rospy.loginfo('The background is red %d, green %d, blue %d', red, green, blue)
