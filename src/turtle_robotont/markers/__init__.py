"""AR markers: sightings, tours, the rendered sequence. Without ROS."""
