#!/usr/bin/env python3
import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose


class Turtle:
    x = 0.0

    def update(self, pose):
        self.x = pose.x


turtle = Turtle()
rospy.init_node('busy')
pub = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=1)
rospy.Subscriber('/turtle1/pose', Pose, turtle.update)
twist = Twist()
while not rospy.is_shutdown():
    twist.linear.x = 1.0 if turtle.x < 10.0 else 0.0
    pub.publish(twist)
