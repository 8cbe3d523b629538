"""What the nodes of the simulators and the course need in addition to rospy."""
