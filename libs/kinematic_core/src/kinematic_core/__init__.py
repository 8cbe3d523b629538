"""Planar motion of simulated robots in fixed time steps: no clock, no ROS, no random numbers but seeded ones."""
