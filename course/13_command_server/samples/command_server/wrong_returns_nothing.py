#!/usr/bin/env python3
# expected: failed: required check failed
import rospy
from geometry_msgs.msg import Twist
from std_srvs.srv import Trigger

driving = False


def command(request):
    global driving
    driving = True


rospy.init_node('turtle_command_server')
publisher = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=10)
rospy.Service('/turtle_command', Trigger, command)
rate = rospy.Rate(10)
while not rospy.is_shutdown():
    if driving:
        twist = Twist()
        twist.linear.x = 0.5
        twist.angular.z = 0.2
        publisher.publish(twist)
    rate.sleep()
