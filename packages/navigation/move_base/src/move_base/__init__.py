"""move_base: drives a robot to goals on a map."""
