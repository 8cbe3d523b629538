# expected: passed
rosrun turtle_robotont pose_subscriber.py
