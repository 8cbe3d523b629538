#!/usr/bin/env python3
import rospy
from geometry_msgs.msg import Twist

rospy.init_node('circle')
pub = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=10)
rate = rospy.Rate(10)
twist = Twist()
twist.linear.x = 0.5
twist.angular.z = 0.2
while not rospy.is_shutdown():
    pub.publish(twist)
    rospy.loginfo('sent %.1f m/s and %.1f rad/s', twist.linear.x, twist.angular.z)
    try:
        rate.sleep()
    except rospy.ROSInterruptException:
        break
