# expected: passed
# isolation: none, for the nodes of the course
rosrun turtle_robotont drive_shape.py
