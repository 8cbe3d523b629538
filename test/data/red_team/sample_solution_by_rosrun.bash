#!/bin/bash
# expected: failed
# exercise: stop_at_x
# at none: open
rosrun turtle_robotont stop_at_x.py
