"""Many submissions. Without ROS."""
