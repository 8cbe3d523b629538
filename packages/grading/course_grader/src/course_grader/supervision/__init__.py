"""Decides how a program is graded and repeats attempts until there is a verdict. Without ROS."""
