#!/usr/bin/env python3
# expected: failed: 0 commands
import rospy
from geometry_msgs.msg import Twist

rospy.init_node('circle')
pub = rospy.Publisher('/turtle/cmd_vel', Twist, queue_size=10)
rate = rospy.Rate(10)
twist = Twist()
twist.linear.x = 0.5
twist.angular.z = 0.2
while not rospy.is_shutdown():
    pub.publish(twist)
    rospy.loginfo('sent %.1f %.1f', twist.linear.x, twist.angular.z)
    rate.sleep()
