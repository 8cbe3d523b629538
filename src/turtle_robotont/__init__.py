"""The turtle course's own nodes: ROS-free logic (control, shapes, checks) and the node layer on top of it."""
