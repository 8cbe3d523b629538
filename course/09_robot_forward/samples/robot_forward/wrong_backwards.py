#!/usr/bin/env python3
# expected: failed: linear.x -0.20 m/s
import rospy
from geometry_msgs.msg import Twist

rospy.init_node('forward')
pub = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
rate = rospy.Rate(1)
while not rospy.is_shutdown():
    twist = Twist()
    twist.linear.x = -0.2
    pub.publish(twist)
    rospy.loginfo('linear %.2f angular %.2f', twist.linear.x, twist.angular.z)
    try:
        rate.sleep()
    except rospy.ROSInterruptException:
        pass
