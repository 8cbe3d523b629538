"""The part of ROS 2's ament_index_python that PyPI's xacro calls; it looks packages up as ROS 1 does."""
