"""What needs no ROS: what a browser asks for, and pictures as it can show them."""
