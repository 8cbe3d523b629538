"""Keep a node known to the ROS master, also to one that was started anew.

rospy registers a topic or service once. When roscore is stopped and started again, a node that lives on is
invisible to it for ever; here it notices and registers everything it has again.
"""
import http.client
import threading
import xmlrpc.client

import rosgraph
import rospy

from kinematic_ros import rospy_internals

PERIOD = 1.0  # [s] between two looks at the master


def keep_registered(on_return=None, period=PERIOD):
    """Watch the master from a thread of its own; call ``on_return()`` after each registration anew (parameters)."""
    ended = threading.Event()
    rospy.on_shutdown(ended.set)

    def watch():
        lost = False  # until all is registered: the master knows the node as soon as a part of it is
        while not ended.wait(period):
            try:
                lost = lost or not _known()
                if lost:
                    _register_all()
                    if on_return is not None:
                        on_return()
                    lost = False
                    rospy.logwarn('The ROS master was started anew: registered again with it.')
            except (OSError, rosgraph.MasterException, xmlrpc.client.Error, http.client.HTTPException):
                rospy.logwarn_throttle(30.0, 'The ROS master does not answer; going on without it and waiting '
                                       'for it to come back (roscore).')
    thread = threading.Thread(target=watch, name='keep_registered', daemon=True)
    thread.start()
    return thread


def _known():
    """Return whether the master knows this node; raise OSError when there is no master."""
    try:
        rosgraph.Master(rospy.get_name()).lookupNode(rospy.get_name())
        return True
    except rosgraph.MasterError:
        return rospy.is_shutdown()


def _register_all():
    master = rosgraph.Master(rospy.get_name())
    uri = rospy.get_node_uri()
    for name, data_type in rospy_internals.publications():
        master.registerPublisher(name, data_type, uri)
    for name, service_uri in rospy_internals.services():
        master.registerService(name, service_uri, uri)
    this_node = xmlrpc.client.ServerProxy(uri)
    for name, data_type in rospy_internals.subscriptions():
        publishers = master.registerSubscriber(name, data_type, uri)
        this_node.publisherUpdate('/master', name, publishers)  # the slave API's way to say who publishes
