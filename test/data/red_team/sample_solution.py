#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: uses a solution
# at none: open
"""Runs the sample solution of the course as its own node."""
import glob
import os

for pattern in ('/**/scripts/stop_at_x.py', '/**/turtle_robotont/stop_at_x.py', '/**/stop_at_x/right_*.py'):
    for path in glob.glob('/[!pu]*' + pattern, recursive=True):
        os.execvp('python3', ['python3', path])
