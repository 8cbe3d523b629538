#!/usr/bin/env python3
import math

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry


class Robot:
    def __init__(self):
        self.place = None
        self.pub = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
        rospy.Subscriber('/odom', Odometry, self.update)
        self.rate = rospy.Rate(20)

    def update(self, odometry):
        pose = odometry.pose.pose
        heading = 2 * math.atan2(pose.orientation.z, pose.orientation.w)
        self.place = pose.position.x, pose.position.y, heading

    def drive(self, forward, turn):
        twist = Twist()
        twist.linear.x = forward
        twist.angular.z = turn
        self.pub.publish(twist)
        self.rate.sleep()

    def side(self, length):
        x, y, _ = self.place
        while not rospy.is_shutdown():
            left = length - math.hypot(self.place[0] - x, self.place[1] - y)
            if left < 0.01:
                break
            self.drive(min(0.3, left + 0.02), 0.0)
        self.drive(0.0, 0.0)

    def corner(self, angle):
        goal = self.place[2] + angle
        while not rospy.is_shutdown():
            left = math.remainder(goal - self.place[2], 2 * math.pi)
            if abs(left) < 0.01:
                break
            self.drive(0.0, max(-1.0, min(1.0, 2 * left)))
        self.drive(0.0, 0.0)


rospy.init_node('robot_shape')
robot = Robot()
while robot.place is None:
    rospy.sleep(0.1)

for _ in range(3):
    robot.side(0.8)
    robot.corner(2 * math.pi / 3)
