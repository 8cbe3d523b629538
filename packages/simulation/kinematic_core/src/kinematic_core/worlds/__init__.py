"""The simulated worlds: a turtle's arena, a robot among walls, its wheels, camera and laser scanner.

``world_format`` reads and writes them, ``overhead`` draws a map. A world computes the next state from the state, a
command and a fixed time step: without clock and ROS, and with random numbers only from a seed.
"""
