#!/usr/bin/env python3
# expected: failed: follows the solution for
# It grows ten times too fast.
import rospy
from geometry_msgs.msg import Twist

rospy.init_node('spiral')
pub = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=10)
rospy.sleep(1.0)
rate = rospy.Rate(10)
twist = Twist()
twist.linear.x = 0.2
twist.angular.z = 1.5
for _ in range(120):
    pub.publish(twist)
    twist.linear.x += 0.1
    rate.sleep()
pub.publish(Twist())
rospy.sleep(1.0)
