#!/usr/bin/env python3
# expected: failed: No module named 'nav_msg'
import rospy
from geometry_msgs.msg import Twist
from nav_msg.msg import Odometry

rospy.init_node('robot_shape')
pub = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
rospy.Subscriber('/odom', Odometry, print)
rospy.spin()
