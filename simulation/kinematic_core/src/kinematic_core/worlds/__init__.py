"""The simulated worlds: a turtle's arena, a robot among walls, its wheels and laser scanner.

A world computes the next state from the state, a command and a fixed time step: without clock and ROS, and with random
numbers only from a seed.
"""
