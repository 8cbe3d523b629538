#!/usr/bin/env python3
# expected: failed: the program teleported to (10.00,
import rospy
from turtlesim.msg import Pose
from turtlesim.srv import TeleportAbsolute

rospy.init_node('stop_at_10')
pose = rospy.wait_for_message('/turtle1/pose', Pose)
rospy.wait_for_service('/turtle1/teleport_absolute')
teleport = rospy.ServiceProxy('/turtle1/teleport_absolute', TeleportAbsolute)
teleport(10.0, pose.y, 0.0)
rospy.spin()
