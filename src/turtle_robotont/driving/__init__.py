"""Driving of vehicles: control laws, shapes, metrics of a track. Without ROS."""
