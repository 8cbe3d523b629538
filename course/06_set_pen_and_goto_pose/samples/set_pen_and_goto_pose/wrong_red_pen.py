#!/usr/bin/env python3
# expected: failed: pens: (255, 0, 0) width 5
import rospy
from turtlesim.srv import SetPen, TeleportAbsolute, TeleportAbsoluteResponse


def goto_pose(request):
    rospy.loginfo('gotoPose x: %.3f y: %.3f theta: %.3f', request.x, request.y, request.theta)
    return TeleportAbsoluteResponse()


rospy.init_node('service_node')
rospy.wait_for_service('/turtle1/set_pen')
rospy.ServiceProxy('/turtle1/set_pen', SetPen)(255, 0, 0, 5, 0)
rospy.Service('/turtle1/gotoPose', TeleportAbsolute, goto_pose)
rospy.spin()
