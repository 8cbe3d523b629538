#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: reads the memory of others
# at none: open
"""Opens the memory of the other processes."""
import os

for number in filter(str.isdigit, os.listdir('/proc')):
    try:
        with open(f'/proc/{number}/mem', 'r+b') as file:
            if number != str(os.getpid()):
                print('opened', number, flush=True)
    except OSError:
        continue
