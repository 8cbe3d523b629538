#!/usr/bin/env python3
# expected: failed: half of the time within
import rospy
from std_srvs.srv import Empty

rospy.init_node('find_robot')
rospy.wait_for_service('/global_localization')
find = rospy.ServiceProxy('/global_localization', Empty)
find()
rospy.sleep(42.0)
find()
rospy.spin()
