#!/usr/bin/env python3
# expected: failed: robot2: a stop
import math

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry

GAIN, FASTEST = 1.0, 0.5  # [1/s], [m/s]
NEAR = 0.03  # [m]


class Robot:
    def __init__(self, name, x, y):
        self.goal, self.place = (x, y), None
        self.publisher = rospy.Publisher(f'/{name}/cmd_vel', Twist, queue_size=1)
        rospy.Subscriber(f'/{name}/odom', Odometry, self.update)

    def update(self, odometry):
        self.place = odometry.pose.pose.position

    def drive(self):
        """Drive towards the goal; return whether the robot is there."""
        velocity = Twist()
        dx, dy = self.goal[0] - self.place.x, self.goal[1] - self.place.y
        distance = math.hypot(dx, dy)
        if distance > NEAR:
            speed = min(FASTEST, GAIN * distance)
            velocity.linear.x, velocity.linear.y = speed * dx / distance, speed * dy / distance
        self.publisher.publish(velocity)
        return distance <= NEAR


rospy.init_node('two_robots')
robots = [Robot('robot1', 2.0, 2.0), Robot('robot2', 0.0, 2.0)]
rate = rospy.Rate(20)
while not rospy.is_shutdown():
    if all(robot.place for robot in robots) and robots[0].drive():
        pass
    rate.sleep()
