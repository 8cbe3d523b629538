"""Robotont's simulator: its worlds, its camera, its lidar and its node."""
