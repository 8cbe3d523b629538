#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: fills the disk
"""Writes one file of 500 MB."""
import tempfile

with tempfile.TemporaryFile() as file:
    for _ in range(500):
        file.write(bytes(1 << 20))
