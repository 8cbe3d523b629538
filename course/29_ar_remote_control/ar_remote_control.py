#!/usr/bin/env python3
import rospy
from ar_track_alvar_msgs.msg import AlvarMarkers
from geometry_msgs.msg import Twist
from tf.transformations import euler_from_quaternion

SPEED = 0.5  # m/s for each rad of pitch
TURN_SPEED = 1.5  # rad/s for each rad of roll


def control(message):
    velocity = Twist()  # zero: the robot stands while no marker is seen
    # solution
    if message.markers:
        q = message.markers[0].pose.pose.orientation
        roll, pitch, yaw = euler_from_quaternion([q.x, q.y, q.z, q.w])
        velocity.linear.x = SPEED * pitch
        velocity.angular.z = TURN_SPEED * roll
    # end of solution
    publisher.publish(velocity)


rospy.init_node('ar_remote_control')
publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
rospy.Subscriber('/ar_pose_marker', AlvarMarkers, control)
rospy.spin()
