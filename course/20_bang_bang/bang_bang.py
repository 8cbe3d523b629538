#!/usr/bin/env python3
import rospy
from geometry_msgs.msg import Twist
from robotont_laserscan_to_distance.msg import LaserScanSplit


def control(distances):
    velocity = Twist()
    # solution
    if distances.center_min > 0.5:
        velocity.linear.x = 0.2
    else:
        velocity.linear.x = -0.2
    # end of solution
    publisher.publish(velocity)


rospy.init_node('bang_bang')
publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
rospy.Subscriber('/scan_to_distance', LaserScanSplit, control)
rospy.spin()
