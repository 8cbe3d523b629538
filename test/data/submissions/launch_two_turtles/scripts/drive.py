#!/usr/bin/env python3
import rospy
from geometry_msgs.msg import Twist

rospy.init_node('drive')
publisher = rospy.Publisher('cmd_vel', Twist, queue_size=10)
twist = Twist()
twist.linear.x = rospy.get_param('~linear', 1.0)
twist.angular.z = rospy.get_param('~angular', 0.0)
rate = rospy.Rate(10)
while not rospy.is_shutdown():
    publisher.publish(twist)
    rate.sleep()
