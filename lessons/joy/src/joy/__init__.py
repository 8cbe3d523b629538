"""Joysticks of Linux as sensor_msgs/Joy; see README.md."""
