#!/usr/bin/env python3
"""Plays and measures the whole course: a program of the package course_grader."""
from turtle_robotont import elsewhere

if __name__ == '__main__':
    elsewhere.run('course_grader', 'demo')
