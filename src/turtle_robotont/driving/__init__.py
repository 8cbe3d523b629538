"""Driving of vehicles: control laws, shapes, accuracy of a track. Without ROS."""
