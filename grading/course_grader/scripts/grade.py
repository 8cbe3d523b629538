#!/usr/bin/env python3
"""Grades a student's program: what ./run grade runs."""
import sys

from course_grader.cli import main

if __name__ == '__main__':
    sys.exit(main())
