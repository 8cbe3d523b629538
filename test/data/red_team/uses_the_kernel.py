#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: gets more rights
"""Asks kernel interfaces that programs rarely need for what is not its own: io_uring, keys, other files' handles."""
import ctypes

libc = ctypes.CDLL(None, use_errno=True)
IO_URING_SETUP, ADD_KEY, KEYCTL, OPEN_BY_HANDLE, BPF, PERF, USERFAULT = 425, 248, 250, 304, 321, 298, 323
params = ctypes.create_string_buffer(120)
print('io_uring:', libc.syscall(IO_URING_SETUP, 8, params), flush=True)
print('key:', libc.syscall(ADD_KEY, b'user', b'turtle', b'x' * 100, 100, -3), flush=True)
buffer = ctypes.create_string_buffer(4096)
for key in range(-8, 0):
    if libc.syscall(KEYCTL, 11, key, buffer, 4096) > 100:
        print('FOUND a key', buffer.value[:100], flush=True)
handle = ctypes.create_string_buffer(b'\x08\x00\x00\x00\x01\x00\x00\x00\x02' + bytes(7), 24)  # the root's i-node
if libc.syscall(OPEN_BY_HANDLE, 0, handle, 0) >= 0:
    print('opened a file by its handle', flush=True)
for call in BPF, PERF, USERFAULT:
    print(call, libc.syscall(call, 0, params, 0, -1, 0), flush=True)
