rosrun turtle_robotont teleport_tour.py _positions:="[[2,2],[9,2],[9,9],[2,9],[2,2]]"
