#!/usr/bin/env python3
# expected: failed: required check failed: a line with the id
import rospy
from ar_track_alvar_msgs.msg import AlvarMarkers


def callback(message):
    if not message.markers:
        rospy.loginfo('No AR markers detected.')
    for number, _ in enumerate(message.markers, 100):
        rospy.loginfo('Detected marker with ID %d', number)


rospy.init_node('marker_subscriber')
rospy.Subscriber('ar_pose_marker', AlvarMarkers, callback)
rospy.spin()
