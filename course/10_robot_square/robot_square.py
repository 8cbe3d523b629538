#!/usr/bin/env python3
import math

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry

pose = None


def store_pose(message):
    global pose
    pose = message.pose.pose


rospy.init_node('robot_square')
rospy.Subscriber('/odom', Odometry, store_pose)
publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
rate = rospy.Rate(20)
while pose is None and not rospy.is_shutdown():
    rate.sleep()
# solution
x0, y0 = pose.position.x, pose.position.y
for x, y in [(x0 + 0.6, y0), (x0 + 0.6, y0 + 0.6), (x0, y0 + 0.6), (x0, y0)]:
    while math.hypot(x - pose.position.x, y - pose.position.y) > 0.03 and not rospy.is_shutdown():
        direction = math.atan2(y - pose.position.y, x - pose.position.x)
        heading = 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)
        turn = math.remainder(direction - heading, 2.0 * math.pi)
        velocity = Twist()
        velocity.angular.z = 2.0 * turn
        if abs(turn) < 0.1:
            velocity.linear.x = 0.2
        publisher.publish(velocity)
        rate.sleep()
    rospy.loginfo('At x = %.2f m, y = %.2f m', pose.position.x, pose.position.y)
publisher.publish(Twist())
# end of solution
