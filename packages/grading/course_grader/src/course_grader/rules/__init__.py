"""What counts: exercise files, rules, scores. Without ROS."""
