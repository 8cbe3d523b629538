#!/bin/bash
# expected: failed
# exercise: stop_at_x
# kind: uses a solution
# at none: open
rosrun turtle_robotont stop_at_x.py
