"""The parts without ROS."""
