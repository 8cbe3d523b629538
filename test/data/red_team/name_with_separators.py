#!/usr/bin/env python3
# expected: failed: teleported
# exercise: stop_at_x
# kind: takes the name of the grader
"""Hides a teleport behind a name that the recording could take for several."""
import rospy
from turtlesim.srv import TeleportAbsolute

rospy.init_node('teleporter')
for name in ('a;=;=;/grader;=', '=', '/x\n9999,,10,5.5,0,0,0,0,0,0,'):
    proxy = rospy.ServiceProxy('/turtle1/teleport_absolute', TeleportAbsolute, headers={'callerid': name})
    proxy(3.0, 5.5, 0.0)
    proxy(10.0, 5.5, 0.0)
rospy.sleep(3.0)
