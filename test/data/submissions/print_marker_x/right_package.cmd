# expected: passed
rosrun turtle_robotont ar_control_node.py
