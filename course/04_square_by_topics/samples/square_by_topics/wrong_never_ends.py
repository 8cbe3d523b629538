#!/usr/bin/env python3
# expected: failed: required check failed
import rospy
from geometry_msgs.msg import Twist

rospy.init_node('square')
pub = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=1)
rate = rospy.Rate(10)
twist = Twist()
twist.linear.x = 1.0
twist.angular.z = 1.0
while not rospy.is_shutdown():
    pub.publish(twist)
    rate.sleep()
