#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: gets more rights
# at none: open
"""Tries to become root, or the user of another grading, and to signal all that it may."""
import ctypes
import os
import signal

for number in (0, *range(60_706, 60_720)):
    for call in (os.setuid, os.setgid, os.seteuid):
        try:
            if number != os.getuid():
                call(number)
                print('opened', call.__name__, number, flush=True)
        except OSError:
            pass
if ctypes.CDLL(None).prctl(38, 0, 0, 0, 0) == 0 and os.geteuid() == 0:  # no_new_privs off, and root
    os.kill(-1, signal.SIGKILL)
