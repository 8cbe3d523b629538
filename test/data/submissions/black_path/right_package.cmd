# expected: passed
rosrun turtle_robotont teleport_tour.py
