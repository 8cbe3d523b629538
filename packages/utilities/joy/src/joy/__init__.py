"""Linux joysticks as sensor_msgs/Joy; see README.md."""
