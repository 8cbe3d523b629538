"""Results for people and for other systems. Without ROS."""
