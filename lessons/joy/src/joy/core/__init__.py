"""What needs no ROS: the events of a joystick, and its file."""
