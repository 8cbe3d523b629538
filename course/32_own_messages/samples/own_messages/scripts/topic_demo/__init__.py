"""Stands for what catkin_make generates of msg/ and srv/, because the package of a sample is not built."""
