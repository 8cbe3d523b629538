#!/usr/bin/env python3
import time

import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose

x = None


def callback(pose):
    global x
    x = pose.x


rospy.init_node('stop_at_10')
rospy.Subscriber('/turtle1/pose', Pose, callback)
pub = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=1)

while not rospy.is_shutdown() and (x is None or x < 9.97):
    twist = Twist()
    if x is not None:
        twist.linear.x = min(3.0, 2.0 * (10.0 - x))
    pub.publish(twist)
    time.sleep(0.02)
pub.publish(Twist())
time.sleep(0.5)
print('there')
