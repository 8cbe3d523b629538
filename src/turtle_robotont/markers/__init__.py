"""AR markers: sightings and tours. Without ROS."""
