"""World files (YAML, SDF with its meshes) and the renderer that draws them, without ROS."""
