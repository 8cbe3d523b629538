# expected: passed
rosrun turtle_robotont velocity_publisher.py
