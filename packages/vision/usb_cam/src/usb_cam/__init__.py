"""A stand-in for usb_cam: publishes a webcam, a video or a folder of images as image_raw and camera_info."""
