#!/usr/bin/env python3
# expected: failed: it stopped at x = 9.
import signal

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

signal.signal(signal.SIGINT, signal.SIG_IGN)
signal.signal(signal.SIGTERM, signal.SIG_IGN)
rate = rospy.Rate(10)
while True:
    twist = Twist()
    if x is not None and x < 9.0:
        twist.linear.x = 1.0
    pub.publish(twist)
    rate.sleep()
