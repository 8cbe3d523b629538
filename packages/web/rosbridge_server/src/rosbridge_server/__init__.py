"""rosbridge_server: the bridge from WebSocket clients to ROS."""
