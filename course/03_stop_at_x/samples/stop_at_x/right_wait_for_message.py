#!/usr/bin/env python3
import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose

rospy.init_node('one_by_one')
pub = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=1)
x = 0.0
while not rospy.is_shutdown() and x < 10.0:
    x = rospy.wait_for_message('/turtle1/pose', Pose).x
    twist = Twist()
    twist.linear.x = 1.0 if x < 10.0 else 0.0
    pub.publish(twist)
