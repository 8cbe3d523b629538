"""The part without ROS: robots and models from URDF and SDF, and their world."""
