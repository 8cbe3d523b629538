#!/usr/bin/env python3
import math

import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose


class Turtle:
    def __init__(self):
        self.pose = None
        self.pub = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=1)
        rospy.Subscriber('/turtle1/pose', Pose, self.update)
        self.rate = rospy.Rate(30)

    def update(self, pose):
        self.pose = pose

    def go_to(self, x, y):
        while not rospy.is_shutdown():
            dx, dy = x - self.pose.x, y - self.pose.y
            distance = math.hypot(dx, dy)
            turn = math.remainder(math.atan2(dy, dx) - self.pose.theta, 2 * math.pi)
            twist = Twist()
            if distance < 0.02:
                self.pub.publish(twist)
                return
            if abs(turn) > 0.02 and distance > 0.1:
                twist.angular.z = 4 * turn
            else:
                twist.linear.x = min(2.0, 2 * distance)
            self.pub.publish(twist)
            self.rate.sleep()


rospy.init_node('square')
turtle = Turtle()
while turtle.pose is None:
    rospy.sleep(0.1)

for x, y in [(2, 2), (8, 2), (8, 8), (2, 8), (2, 2)]:
    turtle.go_to(x, y)
    rospy.loginfo('reached %d, %d', x, y)
