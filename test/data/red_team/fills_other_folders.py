#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: fills the disk
# at none: open
"""Writes 240 MB beside its own folder, below 1,500 folders, and waits."""
import os
import time

for place in ('/var/tmp', '/dev/shm', '/tmp', '/run/lock'):
    try:
        os.chdir(place)
        for _ in range(1500):
            os.mkdir('d')
            os.chdir('d')
        for number in range(4):
            with open(f'part{number}', 'wb') as file:
                for _ in range(60):
                    file.write(bytes(1 << 20))
    except OSError:
        continue
time.sleep(60)
