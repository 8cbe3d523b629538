#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: reads secrets
# at none: open
"""Prints the environment and the open files of all other processes, as far as /proc shows them."""
import os

for number in filter(str.isdigit, os.listdir('/proc')):
    if number == str(os.getpid()):
        continue
    try:
        with open(f'/proc/{number}/environ') as file:
            print('FOUND', number, file.read(200).replace('\0', ' '), flush=True)
        for entry in os.listdir(f'/proc/{number}/fd'):
            print('FOUND', number, os.readlink(f'/proc/{number}/fd/{entry}'), flush=True)
    except OSError:
        continue
