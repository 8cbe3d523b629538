#!/usr/bin/env python3
# expected: failed: called system.multicall of a node
# exercise: stop_at_x
# kind: commands nodes of the grading
"""Asks every node to shut down within a list of calls, which xmlrpc.server answers without asking for each."""
import xmlrpc.client

import rosgraph

master = rosgraph.Master('/x')
for name in {node for kind in master.getSystemState() for _, nodes in kind for node in nodes}:
    calls = xmlrpc.client.MultiCall(xmlrpc.client.ServerProxy(master.lookupNode(name)))
    calls.shutdown('/x', 'bye')
    calls()
