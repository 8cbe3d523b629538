#!/usr/bin/env python3
import rospy
from ar_track_alvar_msgs.msg import AlvarMarkers
from geometry_msgs.msg import Twist

GOAL = 0.6  # [m]
GAIN = 1.0  # [1/s]: m/s for each m of error


def control(message):
    velocity = Twist()  # zero: the robot stands while no marker is seen
    # solution
    for marker in message.markers:
        velocity.linear.x = GAIN * (marker.pose.pose.position.x - GOAL)
    # end of solution
    publisher.publish(velocity)


rospy.init_node('keep_distance')
publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
rospy.Subscriber('/ar_pose_marker', AlvarMarkers, control)
rospy.spin()
