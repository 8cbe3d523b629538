#!/usr/bin/env python3
# expected: failed
# exercise: command_server
# kind: lets another user do the work
# at none: passed
"""Registers as its own what a program of another user, a_friend.py, offers and publishes; uses the wall clock."""
import time

import rosgraph
import rospy

rospy.init_node('driver')
master = rosgraph.Master('/driver')
master.registerService('/turtle_command', 'rosrpc://localhost:47113', rospy.get_node_uri())
rosgraph.Master('/friend').registerPublisher('/turtle1/cmd_vel', 'geometry_msgs/Twist', 'http://localhost:47112/')
while not rospy.is_shutdown():
    time.sleep(0.1)
