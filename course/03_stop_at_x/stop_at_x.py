#!/usr/bin/env python3
import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose

pose = None


def store_pose(message):
    global pose
    pose = message


rospy.init_node('stop_at_x')
rospy.Subscriber('/turtle1/pose', Pose, store_pose)
publisher = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=10)
rate = rospy.Rate(50)
while pose is None and not rospy.is_shutdown():
    rate.sleep()
# solution
velocity = Twist()
velocity.linear.x = 1.0
while pose.x < 10.0 and not rospy.is_shutdown():
    publisher.publish(velocity)
    rate.sleep()
publisher.publish(Twist())
# end of solution
rospy.loginfo('Stopped at x = %.3f m', pose.x)
