#!/usr/bin/env python3
# expected: failed: the program subscribes
import rospy

rospy.init_node('marker_subscriber')
rospy.spin()
