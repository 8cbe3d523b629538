rosrun turtle_robotont stop_at_x.py
