#!/usr/bin/env python3
# expected: failed: required check failed: a stop at x = 2
import math

import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose

x, y = 2.0, 8.0
pose = None


def store_pose(message):
    global pose
    pose = message


rospy.init_node('drive_to_point')
rospy.Subscriber('/turtle1/pose', Pose, store_pose)
publisher = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=10)
rate = rospy.Rate(50)
while pose is None and not rospy.is_shutdown():
    rate.sleep()
while math.hypot(x - pose.x, y - pose.y) > 0.1 and not rospy.is_shutdown():
    direction = math.atan2(x - pose.x, y - pose.y)
    turn = math.remainder(direction - pose.theta, 2.0 * math.pi)
    velocity = Twist()
    velocity.angular.z = 2.0 * turn
    if abs(turn) < 0.1:
        velocity.linear.x = 1.0
    publisher.publish(velocity)
    rate.sleep()
publisher.publish(Twist())
rospy.loginfo('Stopped at x = %.2f m, y = %.2f m', pose.x, pose.y)
