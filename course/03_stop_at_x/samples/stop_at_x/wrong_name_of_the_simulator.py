#!/usr/bin/env python3
# expected: failed: the program ended the simulator or the grader, by rosnode kill or by a node of the same name
import rospy

rospy.init_node('turtlesim')
rospy.spin()
