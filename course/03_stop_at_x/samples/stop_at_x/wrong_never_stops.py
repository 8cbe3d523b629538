#!/usr/bin/env python3
# expected: failed: it stopped at x = 11.0
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

rate = rospy.Rate(10)
while not rospy.is_shutdown():
    twist = Twist()
    twist.linear.x = 1.0
    if x == 10.0:
        twist.linear.x = 0.0
    pub.publish(twist)
    rate.sleep()
