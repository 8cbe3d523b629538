#!/usr/bin/env python3
import os

import rospy
from geometry_msgs.msg import Twist

rospy.init_node('two_machines')
rospy.loginfo('The master is %s', os.environ['ROS_MASTER_URI'])
rospy.loginfo('I am %s', rospy.get_node_uri())
publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
velocity = Twist()
velocity.linear.x = 0.1
rate = rospy.Rate(10)
while not rospy.is_shutdown():
    publisher.publish(velocity)
    try:
        rate.sleep()
    except rospy.ROSInterruptException:
        break
