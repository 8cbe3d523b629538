#!/usr/bin/env python3
"""Renders pictures of AR markers and prints their folder: a program of the package alvar_core."""
from turtle_robotont import elsewhere

if __name__ == '__main__':
    elsewhere.run('alvar_core', 'marker_sequence')
