#!/usr/bin/env python3
import math

import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose

corners = [(4.0, 4.0), (7.0, 4.0), (7.0, 7.0), (4.0, 7.0), (4.0, 4.0)]
pose = None


def store_pose(message):
    global pose
    pose = message


rospy.init_node('square_by_topics')
rospy.Subscriber('/turtle1/pose', Pose, store_pose)
publisher = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=10)
rate = rospy.Rate(50)
while pose is None and not rospy.is_shutdown():
    rate.sleep()
# solution
for x, y in corners:
    while math.hypot(x - pose.x, y - pose.y) > 0.05 and not rospy.is_shutdown():
        direction = math.atan2(y - pose.y, x - pose.x)
        turn = math.remainder(direction - pose.theta, 2.0 * math.pi)
        velocity = Twist()
        velocity.angular.z = 4.0 * turn
        if abs(turn) < 0.1:
            velocity.linear.x = 1.0
        publisher.publish(velocity)
        rate.sleep()
    publisher.publish(Twist())
    rospy.loginfo('At x = %.2f m, y = %.2f m', pose.x, pose.y)
# end of solution
