#!/usr/bin/env python3
# expected: failed: No module named 'ar_track_alvar
import rospy
from ar_track_alvar.msg import AlvarMarkers


def callback(message):
    if not message.markers:
        rospy.loginfo('No AR markers detected.')
    for marker in message.markers:
        rospy.loginfo('Detected marker with ID %d', marker.id)


rospy.init_node('marker_subscriber')
rospy.Subscriber('ar_pose_marker', AlvarMarkers, callback)
rospy.spin()
