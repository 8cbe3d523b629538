"""individualMarkersNoKinect: every marker by itself, from the pictures of a colour camera."""
import cv2

from ar_track_alvar import command_line, settings
from ar_track_alvar.node import MarkerNode


def main():
    """Run individualMarkersNoKinect."""
    cv2.setNumThreads(1)
    command_line.init_node('individualMarkersNoKinect')
    MarkerNode(settings.read()).run()
