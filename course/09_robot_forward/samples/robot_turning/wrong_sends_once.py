#!/usr/bin/env python3
# expected: failed: 1 commands
import rospy
from geometry_msgs.msg import Twist, Vector3

rospy.init_node('forward')
pub = rospy.Publisher('/cmd_vel', Twist, queue_size=1, latch=True)
pub.publish(Twist(linear=Vector3(0.2, 0, 0), angular=Vector3(0, 0, 0.5)))
rospy.loginfo('linear 0.2 angular 0.5')
rospy.spin()
