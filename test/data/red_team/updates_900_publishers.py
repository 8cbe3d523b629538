#!/usr/bin/env python3
# expected: failed: called publisherUpdate of a node
# exercise: stop_at_x
# kind: floods with publishers
"""Tells the simulator of 900 publishers that do not exist, so that it only tries to connect."""
import xmlrpc.client

import rosgraph

simulator = xmlrpc.client.ServerProxy(rosgraph.Master('/x').lookupNode('/turtlesim'))
for _ in range(20):
    simulator.publisherUpdate('/master', '/turtle1/cmd_vel', [f'http://localhost:{port}/' for port in range(100, 1000)])
