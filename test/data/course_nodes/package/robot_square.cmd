rosrun turtle_robotont drive_shape.py _robot:=true _size:=0.8
