"""Rendered pictures of AR markers with their ground truth. Without ROS."""
