#!/usr/bin/env python3
# expected: failed: still moving
import rospy
from geometry_msgs.msg import Twist
from robotont_laserscan_to_distance.msg import LaserScanSplit


def control(distances):
    twist = Twist()
    twist.linear.x = 0.2 if distances.center_min > 0.5 else -0.2
    publisher.publish(twist)


rospy.init_node('bang_bang')
publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
rospy.Subscriber('/scan_to_distance', LaserScanSplit, control)
rospy.spin()
