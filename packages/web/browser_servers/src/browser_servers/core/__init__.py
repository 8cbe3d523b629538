"""What needs no ROS: the rosbridge protocol, WebSockets, who may connect, and a browser's query for images."""
