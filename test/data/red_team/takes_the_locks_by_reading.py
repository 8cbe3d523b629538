#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: takes all user ids
"""Locks the files of the user ids, for which it is enough to read them."""
import fcntl
import os
import time

taken = []
for folder in '/run/turtle_robotont', '/tmp/turtle_robotont_users':
    for number in range(60_200, 64_000):
        try:
            taken.append(os.open(f'{folder}/user_{number}', os.O_RDONLY))
            fcntl.flock(taken[-1], fcntl.LOCK_EX | fcntl.LOCK_NB)
            print('opened', number, os.getuid(), flush=True)
        except OSError:
            pass
time.sleep(20)
