"""The part of ar_track_alvar that needs no ROS."""
