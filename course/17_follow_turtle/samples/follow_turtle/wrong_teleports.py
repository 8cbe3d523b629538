#!/usr/bin/env python3
# expected: failed: it jumps
import rospy
from turtlesim.msg import Pose
from turtlesim.srv import Spawn, TeleportAbsolute

rospy.init_node('follower')
rospy.wait_for_service('/spawn')
rospy.ServiceProxy('/spawn', Spawn)(4.0, 2.0, 0.0, 'turtle2')
teleport = rospy.ServiceProxy('/turtle2/teleport_absolute', TeleportAbsolute)
while not rospy.is_shutdown():
    pose = rospy.wait_for_message('/turtle1/pose', Pose)
    teleport(pose.x, pose.y, pose.theta)
    rospy.sleep(1.0)
