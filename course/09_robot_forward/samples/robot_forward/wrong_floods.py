#!/usr/bin/env python3
# expected: failed: required check failed: velocity commands
import rospy
from geometry_msgs.msg import Twist

rospy.init_node('forward')
pub = rospy.Publisher('/cmd_vel', Twist, queue_size=10)
twist = Twist()
twist.linear.x = 0.2
while not rospy.is_shutdown():
    pub.publish(twist)
    rospy.loginfo('linear %.2f angular %.2f', twist.linear.x, twist.angular.z)
