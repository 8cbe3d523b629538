"""A master of a test's own, on a port of its own."""
import os
import random
import socket

import rosgraph

from rostest_support.common import Process, until


def start_master():
    """Start a master at ROS_MASTER_URI; return its Process when it answers."""
    master = Process('rosmaster', '--core', '-p', os.environ['ROS_MASTER_URI'].rsplit(':', 1)[1])
    until(rosgraph.is_master_online, 'a master that answers')
    return master


def free_port():
    """Return a port that is free now, below those that systems give to outgoing connections."""
    while True:
        port = random.randrange(15000, 32000)
        with socket.socket() as probe:
            if probe.connect_ex(('localhost', port)) != 0:
                return port
