"""What needs no ROS: robots and models read from URDF and SDF, and the world that they live in."""
