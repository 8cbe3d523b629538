"""The part of usb_cam that needs no ROS."""
