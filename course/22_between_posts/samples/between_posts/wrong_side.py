#!/usr/bin/env python3
# expected: failed: that comes as near as
import rospy
from geometry_msgs.msg import Twist
from robotont_laserscan_to_distance.msg import LaserScanSplit

GAIN = 1.0  # [1/s]: m/s to the side for each m of difference


def control(distances):
    twist = Twist()
    twist.linear.x = 0.2
    twist.linear.y = GAIN * (distances.right_min - distances.left_min)
    publisher.publish(twist)


rospy.init_node('between_posts')
publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
rospy.Subscriber('/scan_to_distance', LaserScanSplit, control)
rospy.spin()
