#!/usr/bin/env python3
# expected: failed: it starts at
import rospy
from turtlesim.srv import Spawn

rospy.init_node('turtle_spawn')
rospy.wait_for_service('/spawn')
print(rospy.ServiceProxy('/spawn', Spawn)(0.0, 2.0, 2.0, 'turtle2').name)
