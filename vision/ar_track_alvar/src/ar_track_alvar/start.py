"""The start of both trackers."""
import sys

import cv2
import rospy

from ar_track_alvar.core.command_line import EXAMPLE, USAGE, UsageError, ros_arguments
from rospy_support import nodes


def init_node(program, declared, usage=USAGE, arguments_of=ros_arguments, example=EXAMPLE):
    """Initialise rospy, with the positional arguments of this process if it has any; exit if these are wrong.

    ``program`` is the name of the program, ``declared`` the parameters.Table of the node.
    """
    cv2.setNumThreads(1)  # the images are small, so more threads would only take more time
    words = rospy.myargv()[1:]
    try:
        nodes.init_node('marker_detect', declared, argv=sys.argv + (arguments_of(words) if words else []))
    except UsageError as error:
        sys.exit(f'{program}: {error}\nUsage: {program} {usage}\n'
                 f'or, better, parameters and remappings: {program} {example}')
    if words:
        rospy.logwarn('Arguments without a name are deprecated; use parameters and remappings.')
