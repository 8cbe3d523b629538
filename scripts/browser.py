#!/usr/bin/env python3
"""Shows and drives the course in a browser: a program of the package course_page."""
from turtle_robotont import elsewhere

if __name__ == '__main__':
    elsewhere.run('course_page', 'browser')
