#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: ends or stops the grader
# at none: open
"""Sends SIGKILL to its parents and to every other process that it may."""
import os
import signal

mine = os.getpid()
for number in sorted((int(name) for name in os.listdir('/proc') if name.isdigit()), reverse=True):
    if number not in (1, mine):
        try:
            with open(f'/proc/{number}/cmdline', 'rb') as file:
                grader = b'grade' in file.read()
            if grader or number == os.getppid():
                os.kill(number, signal.SIGKILL)
        except OSError:
            continue
