#!/usr/bin/env python3
import math

import rospy
from ar_track_alvar_msgs.msg import AlvarMarkers
from geometry_msgs.msg import Twist

GAIN = 1.5  # [1/s]: rad/s for each rad of error


def control(message):
    velocity = Twist()  # zero: the robot stands while no marker is seen
    # solution
    for marker in message.markers:
        position = marker.pose.pose.position
        velocity.angular.z = GAIN * math.atan2(position.y, position.x)
    # end of solution
    publisher.publish(velocity)


rospy.init_node('keep_centre')
publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
rospy.Subscriber('/ar_pose_marker', AlvarMarkers, control)
rospy.spin()
