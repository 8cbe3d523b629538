#!/usr/bin/env python3
# expected: failed: the program killed turtle1
import rospy
from turtlesim.srv import Kill, Spawn

rospy.init_node('stop_at_10')
rospy.wait_for_service('/kill')
rospy.ServiceProxy('/kill', Kill)('turtle1')
rospy.ServiceProxy('/spawn', Spawn)(10.0, 5.5, 0.0, 'turtle1')
rospy.spin()
