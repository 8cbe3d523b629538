"""How vehicles are driven: control laws, shapes, metrics of a track. Without ROS."""
