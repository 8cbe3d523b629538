"""The part of robotont_gazebo that needs no ROS."""
