#!/usr/bin/env python3
# expected: failed: there is no turtle2
import rospy
from turtlesim.srv import Spawn

rospy.init_node('turtle_spawn')
rospy.wait_for_service('/spawn')
add_turtle = rospy.ServiceProxy('/spawn', Spawn)
print('Spawned [name:turtle2]')
