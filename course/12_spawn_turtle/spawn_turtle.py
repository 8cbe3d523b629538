#!/usr/bin/env python3
import rospy
from turtlesim.srv import Spawn

rospy.init_node('spawn_turtle')
# solution
rospy.wait_for_service('/spawn')
spawn = rospy.ServiceProxy('/spawn', Spawn)
answer = spawn(2.0, 2.0, 0.0, 'turtle2')
rospy.loginfo('Made a turtle with the name %s', answer.name)
# end of solution
