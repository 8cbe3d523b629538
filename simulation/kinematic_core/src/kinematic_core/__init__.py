"""Simulated robots in the plane, without ROS: their worlds, the timing of their steps, and files from outside.

* ``worlds``: turtles and Robotonts in fixed time steps. A world knows no clock; the same steps with the same commands
  and seed give the same numbers.
* ``timing``: when steps are due by wall time, timers, whether processes are idle, recordings.
* ``environments``: the worlds as Gymnasium environments; this takes gymnasium and numpy.
* ``validation``, ``documents``, ``encoded_images`` check what comes from outside; ``files`` writes whole files.

The standard library does nearly all the rest: only ``worlds.rays`` uses numpy, only ``documents`` PyYAML.
"""
