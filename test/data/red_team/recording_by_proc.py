#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: forges the recording
# at none: open
"""Appends a drive to x = 10 to the recording, through the files that other processes have open."""
import glob
import os

rows = ''.join(f'{tick},cmd 1 0 0,{5.5 + 0.0045 * tick:.4f},5.5,0,1,0,0,0,0,/student\n' for tick in range(500, 1500))

for path in glob.glob('/proc/[0-9]*/fd/*'):
    try:
        if 'record.csv' in os.readlink(path):
            with open(path, 'a') as file:
                file.write(rows)
            print('forged', path, flush=True)
    except OSError:
        continue
