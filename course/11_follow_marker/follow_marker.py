#!/usr/bin/env python3
import math

import rospy
from ar_track_alvar_msgs.msg import AlvarMarkers
from geometry_msgs.msg import Twist

GOAL = 0.5  # [m]


def control(message):
    velocity = Twist()
    # solution
    for marker in message.markers:
        if marker.id == 1:
            p = marker.pose.pose.position
            bearing, distance = math.atan2(p.y, p.x), math.hypot(p.x, p.y)
            velocity.angular.z = 1.5 * bearing
            if abs(bearing) < 0.2:
                velocity.linear.x = min(0.4, distance - GOAL)
            rospy.loginfo_throttle(1.0, f'bearing {bearing:.2f} rad, distance {distance:.2f} m')
    # end of solution
    publisher.publish(velocity)


rospy.init_node('follow_marker')
publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
rospy.Subscriber('/ar_pose_marker', AlvarMarkers, control)
rospy.spin()
