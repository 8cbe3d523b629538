#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: sends over the network
"""Connects to the outside."""
import socket

for address in (('1.1.1.1', 53), ('8.8.8.8', 443), ('10.0.0.1', 80)):
    try:
        socket.create_connection(address, 2.0)
        print('CONNECTED', address, flush=True)
    except OSError as error:
        print(error)
