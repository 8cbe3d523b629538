"""The robot without ROS."""
