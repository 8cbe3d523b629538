#!/usr/bin/env python3
import rospy
from geometry_msgs.msg import Twist

rospy.init_node('circle')
pub = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
rate = rospy.Rate(10)
twist = Twist()
twist.linear.x = 0.3
twist.angular.z = 0.75
begin = rospy.Time.now()
while rospy.Time.now() - begin < rospy.Duration(9.5):
    pub.publish(twist)
    rate.sleep()
pub.publish(Twist())
rospy.sleep(0.5)
