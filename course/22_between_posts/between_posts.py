#!/usr/bin/env python3
import rospy
from geometry_msgs.msg import Twist
from robotont_laserscan_to_distance.msg import LaserScanSplit

GAIN = 1.0  # [1/s]: m/s to the side for each m of difference


def control(distances):
    velocity = Twist()
    # solution
    velocity.linear.x = 0.2
    velocity.linear.y = GAIN * (distances.left_min - distances.right_min)
    # end of solution
    publisher.publish(velocity)


rospy.init_node('between_posts')
publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
rospy.Subscriber('/scan_to_distance', LaserScanSplit, control)
rospy.spin()
