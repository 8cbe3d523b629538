"""Simulated time under ROS: /clock, pause and step, lockstep, services answered in the simulator's frame."""
