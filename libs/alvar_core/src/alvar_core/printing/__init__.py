"""Printed markers: createMarker's command line, image and bundle files, PDF sheets."""
