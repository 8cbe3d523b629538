"""What the simulators' and the course's nodes need on top of rospy."""
