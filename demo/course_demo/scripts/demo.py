#!/usr/bin/env python3
"""The whole course, played and measured: what ./run demo shows."""
from turtle_robotont.demo.cli import main

if __name__ == '__main__':
    main()
