#!/usr/bin/env python3
# expected: failed: size of all its files
# exercise: stop_at_x
# kind: fills the disk
"""Writes 500 MB in files of 10 MB, and goes on when one fails."""
import os
import time

for number in range(50):
    try:
        with open(os.path.expanduser(f'~/part{number}'), 'wb') as file:
            file.write(bytes(10 << 20))
    except OSError:
        pass
    time.sleep(0.02)
time.sleep(30)
