#!/usr/bin/env python3
# expected: failed: required check failed: a square
import rospy
from turtlesim.srv import TeleportAbsolute

rospy.init_node('teleporter')
rospy.wait_for_service('/turtle1/teleport_absolute')
teleport = rospy.ServiceProxy('/turtle1/teleport_absolute', TeleportAbsolute)
for x, y in [(1, 3), (10, 3), (10, 5), (1, 5), (1, 3)]:
    teleport(x, y, 0.0)
    rospy.sleep(0.5)
