"""Parts without ROS: a browser's query, and images in formats that it can show."""
