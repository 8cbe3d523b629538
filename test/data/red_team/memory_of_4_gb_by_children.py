#!/usr/bin/env python3
# expected: failed: memory of all its processes
# exercise: stop_at_x
# kind: takes all memory
"""Takes 4 GB in eight processes."""
import os
import time

for _ in range(8):
    if os.fork() == 0:
        block = bytearray(512 << 20)
        for place in range(0, len(block), 4096):
            block[place] = 1
        time.sleep(60)
time.sleep(60)
