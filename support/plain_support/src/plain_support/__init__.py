"""Start, find and end processes. Without ROS."""
