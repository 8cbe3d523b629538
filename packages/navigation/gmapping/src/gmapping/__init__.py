"""gmapping: makes a map from laser scans and odometry."""
