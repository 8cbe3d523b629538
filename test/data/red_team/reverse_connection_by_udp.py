#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: sends over the network
"""Asks a server of names for one, and looks for sockets of other programs."""
import glob
import socket

with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as query:
    try:
        query.sendto(b'.', ('1.1.1.1', 53))
        print('SENT', flush=True)
    except OSError as error:
        print(error)
for path in glob.glob('/run/**/*.sock', recursive=True) + glob.glob('/tmp/**/*.sock', recursive=True):
    print('SOCKET', path, flush=True)
