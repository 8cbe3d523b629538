"""The Robotont's URDF, put together from its parts."""
