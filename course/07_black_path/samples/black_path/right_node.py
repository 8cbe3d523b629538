#!/usr/bin/env python3
import rospy
from turtlesim.srv import SetPen, TeleportAbsolute

rospy.init_node('black_path')
rospy.wait_for_service('/turtle1/set_pen')
pen = rospy.ServiceProxy('/turtle1/set_pen', SetPen)
teleport = rospy.ServiceProxy('/turtle1/teleport_absolute', TeleportAbsolute)
pen(0, 0, 0, 4, 0)
for x, y in [(1, 1), (9, 2), (6, 10), (2.5, 7)]:
    teleport(x, y, 0)
    rospy.sleep(1)
