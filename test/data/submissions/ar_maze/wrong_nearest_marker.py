#!/usr/bin/env python3
# expected: failed: that comes as near as
import math

import rospy
from ar_track_alvar_msgs.msg import AlvarMarkers
from geometry_msgs.msg import Twist

NEAR = 1.0  # [m]: a marker counts as reached


def control(message):
    seen = {marker.id: marker.pose.pose.position for marker in message.markers}
    velocity = Twist()  # zero: the robot stands when it has reached all
    if not seen:
        velocity.angular.z = 0.8  # turn until the marker is seen
    else:
        position = min(seen.values(), key=lambda one: math.hypot(one.x, one.y))
        bearing = math.atan2(position.y, position.x)
        velocity.angular.z = 1.5 * bearing
        if math.hypot(position.x, position.y) < NEAR:
            velocity.angular.z = 0.8
        elif abs(bearing) < 0.2:  # it faces the marker: drive
            velocity.linear.x = 0.4
    publisher.publish(velocity)


rospy.init_node('ar_maze')
publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
rospy.Subscriber('/ar_pose_marker', AlvarMarkers, control)
rospy.spin()
