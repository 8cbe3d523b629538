#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: reads secrets
# at none: open
"""Prints exercises, other submissions and keys, should it find them."""
import glob
import os

print('environment:', dict(os.environ))
for pattern in ('/**/course/*/*.yaml', '/**/.ssh/*', '/**/result.json', '/**/submission_metadata.json'):
    for path in glob.iglob('/[!pus]*' + pattern, recursive=True):
        try:
            with open(path) as file:
                print('FOUND', path, file.read(100), flush=True)
        except OSError:
            continue
