#!/usr/bin/env python3
# expected: failed: there is no turtle2
import math

import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose

poses = {}
rospy.init_node('follower')
rospy.wait_for_service('/spawn')
for name in ('turtle1', 'turtle2'):
    rospy.Subscriber(f'/{name}/pose', Pose, lambda pose, name: poses.update({name: pose}), name)
publisher = rospy.Publisher('/turtle2/cmd_vel', Twist, queue_size=10)
rate = rospy.Rate(10)
while not rospy.is_shutdown():
    if len(poses) == 2:
        leader, follower = poses['turtle1'], poses['turtle2']
        x, y = leader.x - follower.x, leader.y - follower.y
        angle = math.atan2(y, x) - follower.theta
        twist = Twist()
        twist.linear.x = math.hypot(x, y)
        twist.angular.z = 4.0 * math.atan2(math.sin(angle), math.cos(angle))
        publisher.publish(twist)
    rate.sleep()
