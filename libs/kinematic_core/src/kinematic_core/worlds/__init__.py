"""The simulated worlds: a turtle's arena, a robot among walls. No clock, no ROS."""
