#!/usr/bin/env python3
import rospy
from turtlesim.srv import TeleportAbsolute

corners = [(3.0, 3.0), (7.0, 3.0), (7.0, 7.0), (3.0, 7.0), (3.0, 3.0)]

rospy.init_node('square_by_teleport')
rospy.wait_for_service('/turtle1/teleport_absolute')
# solution
teleport = rospy.ServiceProxy('/turtle1/teleport_absolute', TeleportAbsolute)
for x, y in corners:
    teleport(x, y, 0.0)
    rospy.loginfo('At x = %.1f m, y = %.1f m', x, y)
    rospy.sleep(0.5)
# end of solution
