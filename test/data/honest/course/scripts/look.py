#!/usr/bin/env python3
import rospy
from ar_track_alvar_msgs.msg import AlvarMarkers


def callback(message):
    for marker in message.markers:
        rospy.loginfo('%.3f', getattr(marker.pose.pose.position, rospy.get_param('~field')))


rospy.init_node('look')
rospy.Subscriber('markers', AlvarMarkers, callback)
rospy.spin()
