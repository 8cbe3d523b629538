#!/usr/bin/env python3
# expected: failed: No module named 'geometry_msg'
import rospy
from geometry_msg.msg import Twist

rospy.init_node('circle')
pub = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=10)
