#!/usr/bin/env python3
import rospy
from turtlesim.srv import SetPen, TeleportAbsolute

DOWN, UP = 0, 1
positions = [(2.0, 3.0, UP), (9.0, 3.0, DOWN), (9.0, 8.0, UP), (2.0, 8.0, DOWN)]

rospy.init_node('black_path')
rospy.wait_for_service('/turtle1/set_pen')
rospy.wait_for_service('/turtle1/teleport_absolute')
# solution
set_pen = rospy.ServiceProxy('/turtle1/set_pen', SetPen)
teleport = rospy.ServiceProxy('/turtle1/teleport_absolute', TeleportAbsolute)
for x, y, off in positions:
    set_pen(0, 0, 0, 5, off)
    teleport(x, y, 0.0)
    rospy.loginfo('At x = %.1f m, y = %.1f m', x, y)
    rospy.sleep(0.5)
# end of solution
