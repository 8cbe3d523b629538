#!/usr/bin/env python3
# expected: failed: the program
# exercise: stop_at_x
# kind: floods with names, parameters, connections
"""Registers names of 3 MB, which the master writes into its log."""
import rosgraph
import rospy

rospy.init_node('long')
for number in range(12):
    rosgraph.Master('/x').registerPublisher(f'/t{number}' + 'x' * 3_000_000, 'std_msgs/String', 'http://localhost:1/')
rospy.spin()
