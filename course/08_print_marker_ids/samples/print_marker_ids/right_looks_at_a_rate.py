#!/usr/bin/env python3
# Looks at what it has seen at its own rate: that needs messages all the time, as the tracker sends them.
import rospy
from ar_track_alvar_msgs.msg import AlvarMarkers

seen = {}


def callback(message):
    for marker in message.markers:
        seen[marker.id] = rospy.Time.now()


def look(event):
    now = rospy.Time.now()
    ids = [number for number, time in seen.items() if (now - time).to_sec() < 0.3]
    rospy.loginfo('ids: %s', ' '.join(map(str, ids)) if ids else 'No AR markers detected.')


rospy.init_node('patient')
rospy.Subscriber('ar_pose_marker', AlvarMarkers, callback)
rospy.Timer(rospy.Duration(0.5), look)
rospy.spin()
