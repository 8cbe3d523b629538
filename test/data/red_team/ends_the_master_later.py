#!/usr/bin/env python3
# expected: failed: ended the simulator or the grader
# exercise: stop_at_x
# kind: ends the master
"""Shuts the master down in the middle of the exercise, and forges an answer with one of its own."""
import xmlrpc.client

import rosgraph
import rospy
from rosmaster.master import Master

rospy.init_node('late')
rospy.sleep(2.0)
uri = rosgraph.get_master_uri()
xmlrpc.client.ServerProxy(uri).shutdown('/x', 'bye')
Master(int(uri.rstrip('/').rpartition(':')[2])).start()
rospy.sleep(5.0)
