#!/usr/bin/env python3
# expected: failed: the program published fake poses on /odom
import rospy
from nav_msgs.msg import Odometry

rospy.init_node('robot_shape')
pub = rospy.Publisher('/odom', Odometry, queue_size=1)
odometry = Odometry()
for x, y in [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)]:
    odometry.pose.pose.position.x = x
    odometry.pose.pose.position.y = y
    pub.publish(odometry)
    rospy.sleep(1.0)
