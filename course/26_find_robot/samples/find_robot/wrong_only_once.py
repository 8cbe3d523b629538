#!/usr/bin/env python3
# expected: failed: half of the time within
import rospy
from geometry_msgs.msg import Twist
from std_srvs.srv import Empty

rospy.init_node('find_robot')
rospy.wait_for_service('/global_localization')
find = rospy.ServiceProxy('/global_localization', Empty)
publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
twist = Twist()
twist.angular.z = 0.8
rate = rospy.Rate(10)

find()
while not rospy.is_shutdown():
    publisher.publish(twist)
    rate.sleep()
