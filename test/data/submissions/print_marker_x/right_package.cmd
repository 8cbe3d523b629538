# expected: passed
# isolation: none, for the nodes of the course
rosrun turtle_robotont ar_control_node.py
