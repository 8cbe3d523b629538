"""What the servers for browsers share: WebSocket clients' access to ROS, rosapi's answers, images as video."""
