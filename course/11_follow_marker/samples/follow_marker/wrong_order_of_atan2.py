#!/usr/bin/env python3
# expected: failed: the marker is to the left by
import math

import rospy
from ar_track_alvar_msgs.msg import AlvarMarkers
from geometry_msgs.msg import Twist


def control(message):
    velocity = Twist()
    for marker in message.markers:
        p = marker.pose.pose.position
        bearing = math.atan2(p.x, p.y)
        velocity.angular.z = 1.5 * bearing
        if abs(bearing) < 0.2:
            velocity.linear.x = min(0.4, math.hypot(p.x, p.y) - 0.5)
    publisher.publish(velocity)


rospy.init_node('follow_marker')
publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
rospy.Subscriber('/ar_pose_marker', AlvarMarkers, control)
rospy.spin()
