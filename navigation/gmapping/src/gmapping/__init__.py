"""gmapping: makes a map of laser scans and odometry."""
