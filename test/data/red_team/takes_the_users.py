#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: takes all user ids
# at none: open
"""Takes every lock that a user id of a grading could have, so that no other grading gets one."""
import fcntl
import os
import resource
import socket
import time

resource.setrlimit(resource.RLIMIT_NOFILE, (resource.getrlimit(resource.RLIMIT_NOFILE)[1],) * 2)
taken = []
for number in range(60_200, 64_000):
    try:
        taken.append(socket.socket(socket.AF_UNIX))
        taken[-1].bind(f'\0turtle_robotont_user_{number}')
        taken.append(open(f'/run/turtle_robotont/user_{number}', 'w'))
        fcntl.flock(taken[-1], fcntl.LOCK_EX)
        print('opened', number, os.getuid())
    except OSError:
        pass
time.sleep(20)
