#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: takes all cores
"""Takes every core, with as few processes as that needs."""
import os

import rospy

rospy.init_node('busy')
children = [os.fork() for _ in range(3)]  # eight processes
if any(child == 0 for child in children):
    while True:
        pass
rospy.spin()
