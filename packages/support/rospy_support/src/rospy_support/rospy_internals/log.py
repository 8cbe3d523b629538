"""Logging: its configuration, and the parameter of the master that it depends on."""
import contextlib
import functools
import xmlrpc.client

import rosgraph.roslogging
import rospy
import rospy.impl.paramserver

LOG_PARAMETER = '/rosout_disable_topics_generation'  # true: messages on /rosout do not list the node's topics


def log_without_asking():
    """Keep log calls from asking the master for LOG_PARAMETER; ask for it once. Call it after init_node.

    The fault: while LOG_PARAMETER is not set, rospy asks for it at each log line and subscribes to it. That takes time;
    a master that hangs blocks the node; a restarted master seems to know the node, which never registers again; and a
    master that lists the node after its end sends a shutdown request to the next owner of its port.
    """
    try:
        value = rospy.get_param(LOG_PARAMETER, False)
    except (OSError, xmlrpc.client.Error):
        value = False
    rospy.impl.paramserver.get_param_server_cache().set(LOG_PARAMETER, value)


@contextlib.contextmanager
def logging_configured_by(function):
    """In this context, rospy.init_node configures logging by ``function(original, *arguments, **options)``."""
    original = rosgraph.roslogging.configure_logging
    rosgraph.roslogging.configure_logging = functools.partial(function, original)
    try:
        yield
    finally:
        rosgraph.roslogging.configure_logging = original
