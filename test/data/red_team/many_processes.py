#!/usr/bin/env python3
# expected: failed: processes and threads at a time
# exercise: stop_at_x
# kind: takes all cores
# at none: open
"""Starts processes until it may not, and keeps them busy."""
import os

while True:
    try:
        if os.fork() == 0:
            while True:
                pass
    except OSError:
        pass
