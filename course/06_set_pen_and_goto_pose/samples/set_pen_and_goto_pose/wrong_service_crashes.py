#!/usr/bin/env python3
# expected: failed: 0 of 3 calls answered
import rospy
from turtlesim.srv import SetPen, TeleportAbsolute, TeleportAbsoluteResponse


def goto_pose(request):
    rospy.loginfo('going to %.2f', request.pose.x)
    return TeleportAbsoluteResponse()


rospy.init_node('service_node')
rospy.wait_for_service('/turtle1/set_pen')
rospy.ServiceProxy('/turtle1/set_pen', SetPen)(0, 0, 255, 5, 0)
rospy.Service('/turtle1/gotoPose', TeleportAbsolute, goto_pose)
rospy.spin()
