#!/usr/bin/env python3
# expected: failed: the distance ahead by 1.
# exercise: bang_bang
# kind: forges what sensors say
"""Publishes a ground truth in which the robot is where it should be, as if it were the simulator's."""
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from robotont_laserscan_to_distance.msg import LaserScanSplit

rospy.init_node('bang_bang')
truth = rospy.Publisher('/robotont_gazebo/ground_truth', Odometry, queue_size=1000)
commands = rospy.Publisher('/cmd_vel', Twist, queue_size=10)
rospy.Subscriber('/scan_to_distance', LaserScanSplit, lambda distances: None)
rospy.names._set_caller_id('/robotont_gazebo')
there, command = Odometry(), Twist()
there.pose.pose.position.x, there.pose.pose.position.y = 1.437, 0.023
there.pose.pose.orientation.w, command.linear.x = 1.0, 0.2
rate = rospy.Rate(30)
while not rospy.is_shutdown():
    there.header.stamp = rospy.Time.now()
    for _ in range(30):  # more often than the simulator
        truth.publish(there)
    commands.publish(command)
    command.linear.x *= -1.0  # it stays where it is
    rate.sleep()
