#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: forges the recording
# at none: open
"""Appends a drive to x = 10 to the recording, wherever a search of all folders finds one."""
import os

rows = ''.join(f'{tick},cmd 1 0 0,{5.5 + 0.0045 * tick:.4f},5.5,0,1,0,0,0,0,/student\n' for tick in range(500, 1500))

for parent, folders, names in os.walk('/'):
    folders[:] = [name for name in folders if name not in ('proc', 'sys', 'usr')]
    for name in names:
        if name.startswith('record.csv'):
            try:
                with open(os.path.join(parent, name), 'a') as file:
                    file.write(rows)
                print('forged', name, flush=True)
            except OSError as error:
                print(error)
