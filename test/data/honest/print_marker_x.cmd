# a node of a package, with a private parameter and other names
rosrun course look.py markers:=/ar_pose_marker _field:=x __name:=marker_x
