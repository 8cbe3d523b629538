#!/usr/bin/env python3
# expected: failed: it is (69, 86, 255)
import rospy
from std_srvs.srv import Empty

rospy.init_node('parameter_config')
rospy.wait_for_service('/clear')
rospy.ServiceProxy('/clear', Empty)()
for name, value in (('background_r', 255), ('background_g', 255), ('background_b', 0)):
    rospy.set_param('/turtlesim/' + name, value)
rospy.loginfo('done')
