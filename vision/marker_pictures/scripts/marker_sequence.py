#!/usr/bin/env python3
"""Renders the image sequence of the AR part, with its ground truth, and prints the folder."""
from turtle_robotont.markers.sequence_cache import main

if __name__ == '__main__':
    main()
