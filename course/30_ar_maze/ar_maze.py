#!/usr/bin/env python3
import math

import rospy
from ar_track_alvar_msgs.msg import AlvarMarkers
from geometry_msgs.msg import Twist

NEAR = 1.0  # [m]: a marker counts as reached
todo = [1, 2, 3, 4, 5]


def control(message):
    seen = {marker.id: marker.pose.pose.position for marker in message.markers}
    velocity = Twist()  # zero: the robot stands when it has reached all
    # solution
    if todo and todo[0] not in seen:
        velocity.angular.z = 0.8  # turn until the marker is seen
    elif todo:
        position = seen[todo[0]]
        bearing = math.atan2(position.y, position.x)
        velocity.angular.z = 1.5 * bearing
        if math.hypot(position.x, position.y) < NEAR:
            rospy.loginfo('Reached marker %d', todo.pop(0))
        elif abs(bearing) < 0.2:  # it faces the marker: drive
            velocity.linear.x = 0.4
    # end of solution
    publisher.publish(velocity)


rospy.init_node('ar_maze')
publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
rospy.Subscriber('/ar_pose_marker', AlvarMarkers, control)
rospy.spin()
