#!/usr/bin/env python3
# expected: passed
import rospy
from turtlesim.srv import Spawn

rospy.init_node('turtle_spawn')
rospy.wait_for_service('/spawn')
answer = rospy.ServiceProxy('/spawn', Spawn)(2.0, 2.0, 0.0, 'turtle2')
print(f'Spawned [name:{answer.name}]')
