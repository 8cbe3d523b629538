"""Timing and recording of simulators. No ROS.

``pacing`` computes when the next step is due; ``stall_free_timer`` leaves out the time in which the machine stood
still; ``idle_threads`` finds out whether other processes are idle; ``recorder`` writes the events of each step.
"""
