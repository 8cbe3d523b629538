"""The simulated worlds: a turtle's arena, a robot among walls, its wheels and laser scanner.

State, command and a fixed time step in, the next state out: no clock, no ROS, no random numbers but those of a seed.
"""
