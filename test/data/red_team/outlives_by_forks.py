#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: outlives the grading
"""A chain of forks with an empty environment, each in a session of its own."""
import os
import signal
import time

for number in range(1, 65):
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    if os.fork():
        os._exit(0)
    os.setsid()
    if number == 5:
        os.execve('/bin/sleep', ['sleep', '3457'], {})
    time.sleep(0.01)
