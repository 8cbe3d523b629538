#!/usr/bin/env python3
import rospy
from ar_track_alvar_msgs.msg import AlvarMarkers


def callback(message):
    for marker in message.markers:
        rospy.loginfo('marker %d: x = %.3f', marker.id, marker.pose.pose.position.x)


rospy.init_node('marker_subscriber')
rospy.Subscriber('ar_pose_marker', AlvarMarkers, callback)
rospy.spin()
