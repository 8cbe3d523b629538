"""Maps, mapping, localisation and path planning of a robot in the plane, without ROS."""
