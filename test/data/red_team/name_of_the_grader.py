#!/usr/bin/env python3
# expected: failed: teleported
# exercise: stop_at_x
# kind: takes the name of the grader
"""Teleports under the name of the grader's own node, as far as a list of all nodes shows it."""
import rosgraph
import rosgraph.network
import rospy
from turtlesim.srv import TeleportAbsolute

rospy.init_node('teleporter')
published, subscribed, _ = rosgraph.Master('/x').getSystemState()
names = {node for kind in (published, subscribed) for _, nodes in kind for node in nodes}
grader = ([name for name in names if 'grader' in name] or ['/grader'])[0]
proxy = rospy.ServiceProxy('/turtle1/teleport_absolute', TeleportAbsolute, headers={'callerid': grader})
proxy(3.0, 5.5, 0.0)
proxy(10.0, 5.5, 0.0)
rospy.sleep(3.0)
