"""Starting, finding and ending processes. Without ROS."""
