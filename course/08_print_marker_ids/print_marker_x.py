#!/usr/bin/env python3
import math

import rospy
from ar_track_alvar_msgs.msg import AlvarMarkers


# solution
def print_positions(message):
    for marker in message.markers:
        p = marker.pose.pose.position
        rospy.loginfo('Marker %d at x = %.3f, y = %.3f, z = %.3f m', marker.id, p.x, p.y, p.z)
        rospy.loginfo('It is %.3f m away', math.hypot(p.x, p.y, p.z))
# end of solution


rospy.init_node('print_marker_x')
rospy.Subscriber('/ar_pose_marker', AlvarMarkers, print_positions)
rospy.spin()
