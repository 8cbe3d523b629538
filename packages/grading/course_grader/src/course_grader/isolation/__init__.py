"""Isolates a graded program, and ends everything that it started. Without ROS."""
