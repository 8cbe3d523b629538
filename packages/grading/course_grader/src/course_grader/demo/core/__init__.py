"""The measurements of the demo. Without ROS."""
