"""Printed markers: the command line of createMarker, image and bundle files, PDF sheets."""
