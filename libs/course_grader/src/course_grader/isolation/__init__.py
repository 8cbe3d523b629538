"""What a graded program may do, and the end of whatever it started. Without ROS."""
