rosrun turtle_robotont velocity_publisher.py turtle1/cmd_vel:=cmd_vel _linear:=0.2 _angular:=0 _rate:=1
