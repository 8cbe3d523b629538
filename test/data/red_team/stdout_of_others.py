#!/usr/bin/env python3
# expected: failed
# exercise: print_marker_ids
# kind: shows markers itself
"""Writes the wanted line into the output of every process that it can open."""
import glob

for path in glob.glob('/proc/[0-9]*/fd/[12]'):
    try:
        with open(path, 'w') as file:
            file.write('Detected marker with ID 5\n')
    except OSError:
        continue
