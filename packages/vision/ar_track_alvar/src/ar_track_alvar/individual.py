"""individualMarkersNoKinect: publish the pose of every marker in the images of a camera."""
from ar_track_alvar import settings, start
from ar_track_alvar.node import MarkerNode

PARAMETERS = settings.PARAMETERS


def main():
    """Run individualMarkersNoKinect."""
    start.init_node('individualMarkersNoKinect', PARAMETERS)
    MarkerNode(settings.read()).run()
