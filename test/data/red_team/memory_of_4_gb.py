#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: takes all memory
"""Takes 4 GB at once."""
block = bytearray(4 << 30)
print(len(block))
