#!/usr/bin/env python3
# expected: failed
# exercise: command_server
# kind: forges the clock
"""Publishes a time at which all is over, in connections that claim to be the simulator's, and offers a service."""
import rospy
from rosgraph_msgs.msg import Clock
from std_srvs.srv import Trigger

rospy.init_node('late')
rospy.Service('/turtle_command', Trigger, lambda request: (True, ''))
clock = rospy.Publisher('/clock', Clock, queue_size=1, latch=True)
rospy.names._set_caller_id('/turtlesim')
message = Clock()
message.clock = rospy.Time(100_000.0)
while not rospy.is_shutdown():
    clock.publish(message)
    rospy.sleep(0.1)
