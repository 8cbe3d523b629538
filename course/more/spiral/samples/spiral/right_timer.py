#!/usr/bin/env python3
import rospy
from geometry_msgs.msg import Twist


class Spiral:
    def __init__(self):
        self.pub = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=1)
        self.speed = 0.2
        self.timer = rospy.Timer(rospy.Duration(0.1), self.step)

    def step(self, event):
        if self.pub.get_num_connections() == 0:
            return
        twist = Twist()
        if self.speed < 1.4:
            twist.linear.x = self.speed
            twist.angular.z = 1.5
            self.speed += 0.01
        self.pub.publish(twist)


rospy.init_node('spiral_driver')
spiral = Spiral()
rospy.spin()
