"""Grading a student's node: exercise files, what was observed, what counts, and the reports. See exercise.py."""
