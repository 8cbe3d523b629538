"""Turtles as frames of tf, and a turtle that follows another one: the nodes of turtle_tf and turtle_tf2."""
