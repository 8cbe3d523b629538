"""A stand-in for usb_cam: a webcam, a video or a folder of pictures as image_raw and camera_info."""
