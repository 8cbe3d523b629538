"""What the demo measures. Without ROS."""
