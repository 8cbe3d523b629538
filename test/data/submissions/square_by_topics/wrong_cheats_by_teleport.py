#!/usr/bin/env python3
# expected: failed: the program teleported to (2.00, 2.00) instead of driving
import rospy
from turtlesim.srv import TeleportAbsolute

rospy.init_node('square')
rospy.wait_for_service('/turtle1/teleport_absolute')
teleport = rospy.ServiceProxy('/turtle1/teleport_absolute', TeleportAbsolute)
for x, y in [(2, 2), (8, 2), (8, 8), (2, 8), (2, 2)]:
    teleport(x, y, 0)
    rospy.sleep(0.5)
