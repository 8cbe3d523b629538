"""Simulated time under ROS: /clock, pause and step, lockstep, services answered in the next step, recorded worlds."""
