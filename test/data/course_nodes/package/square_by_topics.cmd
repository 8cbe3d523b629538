rosrun turtle_robotont drive_shape.py
