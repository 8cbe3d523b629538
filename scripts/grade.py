#!/usr/bin/env python3
"""Grades a student's program: a program of the package course_grader."""
from turtle_robotont import elsewhere

if __name__ == '__main__':
    elsewhere.run('course_grader', 'grade')
