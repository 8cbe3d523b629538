#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: harms a classmate
"""Finds the masters of others among the listening ports that /proc/net/tcp lists, without a scan."""
import os
import socket
import xmlrpc.client

socket.setdefaulttimeout(1.0)
with open('/proc/net/tcp') as file:
    rows = [line.split() for line in file.readlines()[1:]]
for port in sorted({int(row[1].partition(':')[2], 16) for row in rows if row[3] == '0A'}):
    uri = f'http://localhost:{port}/'
    try:
        code, _, state = xmlrpc.client.ServerProxy(uri).getSystemState('/x')
    except Exception:
        continue
    if code == 1 and uri.rstrip('/') != os.environ['ROS_MASTER_URI'].rstrip('/'):
        print('FOUND', uri, state, flush=True)
