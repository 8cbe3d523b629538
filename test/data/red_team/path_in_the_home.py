#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: leaves files for the next one
"""Leaves a .pth file and a usercustomize in the home folder, and starts Python anew, which would run them."""
import os
import site
import subprocess
import sys

folder = site.getusersitepackages()
os.makedirs(folder, exist_ok=True)
with open(os.path.join(folder, 'evil.pth'), 'w') as file:
    file.write("import os; os.write(1, b'POISONED')\n")
subprocess.run([sys.executable, '-c', 'pass'], check=False)
