#!/usr/bin/env python3
# expected: failed: never offered
# exercise: fibonacci_server
# kind: lets another user do the work
# at none: open
"""Waits for a node of somebody else on this machine, a_friend.py, which does what is asked."""
from threading import Event

import rosgraph
import rospy

wait = Event().wait  # the grader does not see that it uses the wall clock
for _ in range(300):
    if any('/friend' in nodes for _, nodes in rosgraph.Master('/waits').getSystemState()[0]):
        break
    wait(0.1)
rospy.init_node('waits')
rospy.spin()
