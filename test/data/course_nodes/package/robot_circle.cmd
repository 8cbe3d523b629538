rosrun turtle_robotont drive_shape.py _robot:=true _shape:=circle _size:=0.8
