#!/usr/bin/env python3
# expected: failed: it is 69
import rospy
from std_srvs.srv import Empty

rospy.init_node('parameter_config')
rospy.wait_for_service('/clear')
for name, value in (('background_r', 255), ('background_g', 255), ('background_b', 0)):
    rospy.set_param('/' + name, value)
rospy.ServiceProxy('/clear', Empty)()
rospy.loginfo('done')
