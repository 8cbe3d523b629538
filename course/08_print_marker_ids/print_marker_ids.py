#!/usr/bin/env python3
import rospy
from ar_track_alvar_msgs.msg import AlvarMarkers


# solution
def print_ids(message):
    if not message.markers:
        rospy.loginfo('No AR markers detected.')
    for marker in message.markers:
        rospy.loginfo('Detected marker with ID %d', marker.id)
# end of solution


rospy.init_node('print_marker_ids')
rospy.Subscriber('/ar_pose_marker', AlvarMarkers, print_ids)
rospy.spin()
