#!/usr/bin/env python3
# expected: failed: the program subscribes
import rospy

rospy.init_node('poses')
rate = rospy.Rate(10)
while not rospy.is_shutdown():
    rospy.loginfo('x: %.6f, y: %.6f', 5.544445, 5.544445)
    rate.sleep()
