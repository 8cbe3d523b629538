#!/usr/bin/env python3
import sys

sys.path = [folder for folder in sys.path if folder not in sys.path[:1]]  # xacro.py there is not the module xacro
from xacro import main  # noqa: E402

if __name__ == '__main__':
    sys.exit(main())
