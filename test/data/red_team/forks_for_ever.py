#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: takes all cores
"""Eight chains of processes, each of which starts the next one and ends, so that nobody ever finds it busy for long."""
import os
import time

chain = [os.fork() for _ in range(3)]
begun = time.monotonic()
while time.monotonic() - begun < 600.0:
    end = time.monotonic() + 0.02
    while time.monotonic() < end:
        pass
    if os.fork():
        os._exit(0)
    os.setsid()
