#!/usr/bin/env python3
# expected: failed: filled the memory of the master
# exercise: stop_at_x
# kind: floods with names, parameters, connections
"""Sets parameters of 25 MB, which the master keeps."""
import rospy

rospy.init_node('large')
for number in range(40):
    rospy.set_param(f'/large/{number}', 'x' * 25_000_000)
rospy.spin()
