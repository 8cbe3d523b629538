#!/usr/bin/env python3
# expected: failed: the marker is ahead by
import rospy
from ar_track_alvar_msgs.msg import AlvarMarkers
from geometry_msgs.msg import Twist

GOAL = 0.6  # [m]
GAIN = 1.0  # [1/s]: m/s for each m of error


def control(message):
    twist = Twist()  # it stands while no marker is seen
    for marker in message.markers:
        twist.linear.x = GAIN * (marker.pose.pose.position.z - GOAL)
    publisher.publish(twist)


rospy.init_node('keep_distance')
publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
rospy.Subscriber('/ar_pose_marker', AlvarMarkers, control)
rospy.spin()
