"""What needs no ROS: when a transform has changed enough to be sent."""
