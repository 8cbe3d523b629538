#!/usr/bin/env python3
# expected: failed: 0 commands
import rospy

rospy.init_node('forward')
while not rospy.is_shutdown():
    rospy.loginfo('linear 0.20 angular 0.00')
    rospy.sleep(1.0)
