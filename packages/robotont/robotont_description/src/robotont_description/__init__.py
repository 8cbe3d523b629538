"""The Robotont's URDF, and the start of rviz."""
