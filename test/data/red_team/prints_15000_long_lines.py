#!/usr/bin/env python3
# expected: failed
# exercise: print_poses
# kind: floods with lines
"""Prints lines that a careless pattern would search for minutes."""
import rospy

rospy.init_node('long')
for _ in range(15_000):
    print('1 ' * 4_000 + 'x', flush=True)
rospy.spin()
