#!/usr/bin/env python3
# expected: failed: called shutdown of a node
# exercise: stop_at_x
# kind: commands nodes of the grading
"""Asks every node to shut down by the slave API, as rosnode kill does."""
import xmlrpc.client

import rosgraph

master = rosgraph.Master('/x')
for name in {node for kind in master.getSystemState() for _, nodes in kind for node in nodes}:
    xmlrpc.client.ServerProxy(master.lookupNode(name)).shutdown('/x', 'bye')
