#!/usr/bin/env python3
# expected: failed: 0 of
import rospy
from ar_track_alvar_msgs.msg import AlvarMarkers


def callback(message):
    if not message.markers:
        rospy.loginfo('No AR markers detected.')
    for marker in message.markers:
        rospy.loginfo('Detected marker with ID %d', marker.id)


rospy.init_node('marker_subscriber')
rospy.Subscriber('/ar_pose_markers', AlvarMarkers, callback)
rospy.spin()
