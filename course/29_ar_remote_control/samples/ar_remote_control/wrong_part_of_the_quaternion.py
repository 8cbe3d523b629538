#!/usr/bin/env python3
# expected: failed: it fits in
import rospy
from ar_track_alvar_msgs.msg import AlvarMarkers
from geometry_msgs.msg import Twist

SPEED = 0.5  # m/s for each rad of pitch
TURN_SPEED = 1.5  # rad/s for each rad of roll


def control(message):
    velocity = Twist()  # zero: the robot stands while no marker is seen
    if message.markers:
        q = message.markers[0].pose.pose.orientation
        velocity.linear.x = SPEED * q.y
        velocity.angular.z = TURN_SPEED * q.x
    publisher.publish(velocity)


rospy.init_node('ar_remote_control')
publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
rospy.Subscriber('/ar_pose_marker', AlvarMarkers, control)
rospy.spin()
