"""Simulated robots in the plane, without ROS: their worlds, and the timing of their steps.

* ``worlds``: turtles and Robotonts in fixed time steps. A world knows no clock; the same steps with the same commands
  and seed give the same numbers.
* ``timing``: when steps are due by wall time, timers, whether processes are idle, recordings.

plain_support and the standard library do nearly all the rest: numpy is for ``worlds.rays``, ``camera`` and ``sectors``,
OpenCV for ``worlds.overhead``.
"""
