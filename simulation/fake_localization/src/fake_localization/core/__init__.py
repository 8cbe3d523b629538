"""What needs no ROS: frames in the plane."""
