#!/usr/bin/env python3
# expected: failed: 0: none
import rospy
from turtlesim.srv import TeleportAbsolute

rospy.init_node('teleporter')
rospy.wait_for_service('/turtle/teleport_absolute')
teleport = rospy.ServiceProxy('/turtle/teleport_absolute', TeleportAbsolute)
for x, y in [(3, 3), (7, 3), (7, 7), (3, 7), (3, 3)]:
    teleport(x, y, 0.0)
    rospy.sleep(0.5)
