#!/usr/bin/env python3
# expected: failed: 1 of 3 calls answered
import threading

import rospy
from turtlesim.srv import SetPen, TeleportAbsolute, TeleportAbsoluteResponse

called = threading.Event()


def goto_pose(request):
    rospy.loginfo('gotoPose x: %.3f y: %.3f theta: %.3f', request.x, request.y, request.theta)
    called.set()
    return TeleportAbsoluteResponse()


rospy.init_node('service_node')
rospy.wait_for_service('/turtle1/set_pen')
rospy.ServiceProxy('/turtle1/set_pen', SetPen)(0, 0, 255, 5, 0)
service = rospy.Service('/turtle1/gotoPose', TeleportAbsolute, goto_pose)
called.wait()
service.shutdown()
rospy.spin()
