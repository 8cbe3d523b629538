#!/usr/bin/env python3
"""Renders pictures of AR markers and prints their folder: a program of the package marker_pictures."""
from turtle_robotont import elsewhere

if __name__ == '__main__':
    elsewhere.run('marker_pictures', 'marker_sequence')
