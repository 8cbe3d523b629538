#!/usr/bin/env python3
# expected: failed: 0 of
import rospy
from std_msgs.msg import String


def callback(message):
    rospy.loginfo('marker %s', message.data)


rospy.init_node('marker_subscriber')
rospy.Subscriber('ar_pose_marker', String, callback)
rospy.spin()
