"""The part without ROS: frames in the plane."""
