# expected: passed
# isolation: none, for the nodes of the course
rosrun turtle_robotont stop_at_x.py
