#!/usr/bin/env python3
# expected: failed: too many connections
# exercise: stop_at_x
# kind: floods with names, parameters, connections
"""Connects to the master and the simulator until nothing is left, and says nothing there."""
import resource
import socket
import time
import urllib.parse

import rosgraph

most = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
uris = [rosgraph.get_master_uri(), rosgraph.Master('/x').lookupNode('/turtlesim')]
held = []
for number in range(20_000):
    try:
        held.append(socket.create_connection(('localhost', urllib.parse.urlsplit(uris[number % 2]).port), 1.0))
    except OSError:
        time.sleep(0.01)
time.sleep(20)
