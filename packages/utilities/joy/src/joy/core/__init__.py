"""The part without ROS: the events of a joystick, and its device file."""
