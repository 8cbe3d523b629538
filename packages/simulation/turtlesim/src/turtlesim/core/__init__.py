"""The part of turtlesim that needs no ROS."""
