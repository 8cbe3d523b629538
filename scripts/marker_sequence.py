#!/usr/bin/env python3
"""Renders the picture sequence of the AR part, with what is true in it; prints the folder."""
from turtle_robotont.markers.sequence_cache import main

if __name__ == '__main__':
    main()
