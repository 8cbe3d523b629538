#!/usr/bin/env python3
# expected: passed
import rospy
from std_srvs.srv import Empty

rospy.init_node('parameter_config')
rospy.wait_for_service('/clear')
for name in ('background_r', 'background_g', 'background_b'):
    rospy.set_param('/turtlesim/' + name, 255)
rospy.ServiceProxy('/clear', Empty)()
rospy.loginfo('done')
