#!/usr/bin/env python3
# expected: failed
# exercise: print_poses
# kind: floods with lines
"""Prints 60 MB of digits without the end of a line."""
import sys

import rospy

rospy.init_node('endless')
for _ in range(600):
    sys.stdout.write('5' * 100_000)
rospy.spin()
