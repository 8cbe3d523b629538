#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: reads the memory of others
# at none: open
"""Attaches to the other processes as a debugger does, and reads their memory."""
import ctypes
import os

library = ctypes.CDLL(None, use_errno=True)
for number in map(int, filter(str.isdigit, os.listdir('/proc'))):
    if number != os.getpid() and library.ptrace(16, number, 0, 0) == 0:
        print('attached', number, flush=True)
