#!/usr/bin/env python3
# expected: failed: the program published fake poses on /turtle1/pose
import rospy
from turtlesim.msg import Pose

rospy.init_node('stop_at_10')
pub = rospy.Publisher('/turtle1/pose', Pose, queue_size=1)
rate = rospy.Rate(10)
while not rospy.is_shutdown():
    pub.publish(Pose(x=10.0, y=5.5))
    rate.sleep()
