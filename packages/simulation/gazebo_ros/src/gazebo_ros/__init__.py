"""The simulator behind the names of Gazebo; see README.md."""
