#!/usr/bin/env python3
# expected: failed: called publisherUpdate of a node
# exercise: follow_turtle
# kind: forges the clock
"""Tells the grader's own node alone that this node publishes /clock, so that its stimuli end at once."""
import xmlrpc.client

import rosgraph
import rospy
from geometry_msgs.msg import Twist
from rosgraph_msgs.msg import Clock
from turtlesim.msg import Pose
from turtlesim.srv import Spawn

rospy.init_node('follower')
poses = []
rospy.Subscriber('/turtle1/pose', Pose, poses.append)
clock = rospy.Publisher('/clock_of_mine', Clock, queue_size=1)
clock.impl.resolved_name = '/clock'
rospy.topics.get_topic_manager().pubs['/clock'] = clock.impl
master = rosgraph.Master('/follower')
for name in {node for kind in master.getSystemState() for _, nodes in kind for node in nodes if 'grader' in node}:
    xmlrpc.client.ServerProxy(master.lookupNode(name)).publisherUpdate('/master', '/clock', [rospy.get_node_uri()])
late = Clock()
late.clock = rospy.Time(1000.0)
for _ in range(50):
    clock.publish(late)
    rospy.sleep(0.016)
rospy.ServiceProxy('/spawn', Spawn)(poses[-1].x, poses[-1].y, 0.0, 'turtle2')
rospy.Publisher('/turtle2/cmd_vel', Twist, queue_size=1).publish(Twist())
rospy.spin()
