"""What a simulator needs besides its world: the wall clock, other processes, a file. No ROS.

``pacing`` says when the next step is due; ``stall_free_timer`` leaves out the time in which the machine stood still;
``idle_threads`` tells whether other processes are idle; ``recorder`` writes what happened in each step.
"""
