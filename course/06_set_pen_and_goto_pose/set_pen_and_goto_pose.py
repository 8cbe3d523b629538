#!/usr/bin/env python3
import rospy
from turtlesim.srv import SetPen, TeleportAbsolute, TeleportAbsoluteResponse


# solution
def goto_pose(goal):
    rospy.loginfo('Service => x: %g y: %g theta: %g', goal.x, goal.y, goal.theta)
    return TeleportAbsoluteResponse()
# end of solution


rospy.init_node('set_pen_and_goto_pose')
rospy.wait_for_service('/turtle1/set_pen')
set_pen = rospy.ServiceProxy('/turtle1/set_pen', SetPen)
# solution
set_pen(0, 0, 255, 5, 0)
rospy.Service('/turtle1/gotoPose', TeleportAbsolute, goto_pose)
# end of solution
rospy.loginfo('Ready to command gotoPose service.')
rospy.spin()
