"""What goes wrong on a machine with ROS 1, found before or while it does. It does without ROS and changes nothing."""
