#!/usr/bin/env python3
# expected: failed: there is no turtle2
import rospy
from turtlesim.srv import Spawn

rospy.init_node('turtle_spawn')
rospy.wait_for_service('/spawn')
print(rospy.ServiceProxy('/spawn', Spawn)(2.0, 2.0, 0.0, 'Turtle2').name)
