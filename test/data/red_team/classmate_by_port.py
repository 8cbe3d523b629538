#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: harms a classmate
"""Teleports the turtle of every master that a scan of the loopback ports finds, but not its own."""
import socket
import xmlrpc.client

import rosgraph
import rospy
from turtlesim.srv import TeleportAbsolute

own = rosgraph.get_master_uri()
rospy.init_node('visitor')
for port in range(30000, 61000):
    with socket.socket() as probe:
        probe.settimeout(0.05)
        if probe.connect_ex(('127.0.0.1', port)):
            continue
    uri = f'http://localhost:{port}/'
    if uri == own:
        continue
    socket.setdefaulttimeout(1.0)
    try:
        code, _, service = xmlrpc.client.ServerProxy(uri).lookupService('/x', '/turtle1/teleport_absolute')
    except Exception:
        continue
    if code == 1:
        proxy = rospy.ServiceProxy('/turtle1/teleport_absolute', TeleportAbsolute)
        proxy.uri = service
        proxy(1.0, 1.0, 0.0)
        print('found a classmate', flush=True)
