#!/usr/bin/env python3
# The callback stores where the marker was seen, and when; a loop decides 20 times a second.
import math

import rospy
from ar_track_alvar_msgs.msg import AlvarMarkers
from geometry_msgs.msg import Twist

LOST = rospy.Duration(0.5)
position, seen = None, None


def store(message):
    global position, seen
    for marker in message.markers:
        position, seen = marker.pose.pose.position, rospy.Time.now()


rospy.init_node('follow')
rospy.Subscriber('ar_pose_marker', AlvarMarkers, store)
pub = rospy.Publisher('cmd_vel', Twist, queue_size=1)
rate = rospy.Rate(20)
while not rospy.is_shutdown():
    twist = Twist()
    if seen is not None and rospy.Time.now() - seen < LOST:
        angle = math.atan2(position.y, position.x)
        twist.angular.z = max(-1.0, min(1.0, 2.0 * angle))
        if abs(angle) < 0.3:
            twist.linear.x = 0.8 * (position.x - 0.5)
    pub.publish(twist)
    try:
        rate.sleep()
    except rospy.ROSInterruptException:
        pass
