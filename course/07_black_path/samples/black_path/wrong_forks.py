#!/usr/bin/env python3
# expected: failed: 0: none
import os
import time

for _ in range(5):
    if os.fork() == 0:
        os.setsid()
        if os.fork() == 0:
            while True:
                time.sleep(1.0)
        os._exit(0)
print('forked', flush=True)
