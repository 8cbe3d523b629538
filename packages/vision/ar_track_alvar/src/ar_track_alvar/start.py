"""The start of both trackers."""
import sys

import cv2
import rospy

from ar_track_alvar.core.command_line import EXAMPLE, USAGE, UsageError, ros_arguments
from rospy_support import nodes


def init_node(program, declared, usage=USAGE, arguments_of=ros_arguments, example=EXAMPLE):
    """Initialise rospy, also with positional arguments of the command line; exit if these are wrong.

    ``program`` is the name of the program, ``declared`` the parameters.Table of the node.
    """
    cv2.setNumThreads(1)  # for small images, more threads only cost time
    words = rospy.myargv()[1:]
    try:
        nodes.init_node('marker_detect', declared, argv=sys.argv + (arguments_of(words) if words else []))
    except UsageError as error:
        sys.exit(f'{program}: {error}\nUsage: {program} {usage}\n'
                 f'or, better, parameters and remappings: {program} {example}')
    if words:
        rospy.logwarn('Arguments without a name are deprecated; use parameters and remappings.')
