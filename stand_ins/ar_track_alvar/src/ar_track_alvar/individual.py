"""individualMarkersNoKinect: every marker by itself, from the pictures of a colour camera."""
import sys

import cv2
import rospy

from ar_track_alvar import settings
from ar_track_alvar.command_line import USAGE, UsageError, ros_arguments
from ar_track_alvar.node import MarkerNode


def main():
    """Run individualMarkersNoKinect."""
    cv2.setNumThreads(1)
    words = rospy.myargv()[1:]
    try:
        rospy.init_node('marker_detect', argv=sys.argv + (ros_arguments(words) if words else []))
    except UsageError as error:
        sys.exit(f'individualMarkersNoKinect: {error}\nUsage: individualMarkersNoKinect {USAGE}\n'
                 'or, better, parameters and remappings: individualMarkersNoKinect _marker_size:=10 '
                 '_output_frame:=camera camera_image:=/camera/image_raw camera_info:=/camera/camera_info')
    if words:
        rospy.logwarn('Arguments without a name are deprecated; use parameters and remappings.')
    MarkerNode(settings.read()).run()
