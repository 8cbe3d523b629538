"""Start a private master for a test."""
import os

from rospy_support import own_master
from rostest_support.common import Process


def start_master(port=None):
    """Start a master, on a free port or on ``port``; set ROS_MASTER_URI, and return its Process when it answers."""
    uri, process = own_master.start_master(lambda command: Process(*command), port)
    os.environ['ROS_MASTER_URI'] = uri
    return process


def restart_master():
    """Start a master again at ROS_MASTER_URI; return its Process when it answers."""
    return start_master(int(os.environ['ROS_MASTER_URI'].rstrip('/').rsplit(':', 1)[1]))
