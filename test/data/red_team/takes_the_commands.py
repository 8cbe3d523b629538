#!/usr/bin/env python3
# expected: failed: called publisherUpdate of a node
# exercise: stop_at_x
# kind: commands nodes of the grading
"""Tells the simulator, as the master does, who publishes commands, and a parameter; then drives well."""
import xmlrpc.client

import rosgraph
import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose

rospy.init_node('driver')
poses = []
rospy.Subscriber('/turtle1/pose', Pose, poses.append)
publisher = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=1)
simulator = xmlrpc.client.ServerProxy(rosgraph.Master('/driver').lookupNode('/turtlesim'))
simulator.publisherUpdate('/master', '/turtle1/cmd_vel', [rospy.get_node_uri()])
simulator.paramUpdate('/master', '/use_sim_time', False)
rate = rospy.Rate(10)
while not rospy.is_shutdown():
    twist = Twist()
    twist.linear.x = 1.0 if not poses or poses[-1].x < 9.9 else 0.0
    publisher.publish(twist)
    rate.sleep()
