#!/usr/bin/env python3
import rospy
from geometry_msgs.msg import Twist, Vector3


class Circle:
    def __init__(self):
        self.pub = rospy.Publisher('turtle1/cmd_vel', Twist, queue_size=1)
        self.count = 0
        rospy.Timer(rospy.Duration(0.1), self.send)

    def send(self, event):
        self.pub.publish(Twist(linear=Vector3(0.5, 0, 0), angular=Vector3(0, 0, 0.2)))
        self.count += 1
        print('message number', self.count)


rospy.init_node('timer_circle', anonymous=True)
circle = Circle()
rospy.spin()
