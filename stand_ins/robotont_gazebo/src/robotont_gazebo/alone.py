"""There is one robot a namespace: a second one is told before it disturbs the first."""
import os
import socket
import sys
import xmlrpc.client

import rosgraph
import rosgraph.names

TIMEOUT = 2.0  # [s] for a node to say that it lives


def resolved(name, argv=None):
    """Return the full name that rospy.init_node would give to the node or topic ``name`` of this process."""
    argv = sys.argv if argv is None else argv
    mappings = rosgraph.names.load_mappings(argv)
    namespace = rosgraph.names.get_ros_namespace(argv=argv)
    return rosgraph.names.resolve_name(mappings.get('__name', name), namespace)


def other_robot(node, topic):
    """Return a text about a living node of the name ``node`` or one that publishes ``topic``, or None.

    rospy is not initialised yet: a node of the same name would be shut down by that.
    """
    master = rosgraph.Master(resolved(node))
    own, odometry = resolved(node), _remapped(topic)
    try:
        publishers = dict(master.getSystemState()[0]).get(odometry, [])
        for name in sorted({own, *publishers}):
            if _lives(master, name):
                what = 'has this name' if name == own else f'publishes {odometry}'
                return (f'{name} {what} already: two robots would answer to the same topics. End that one, or start '
                        f'this one in a namespace of its own, e.g. __ns:=robot2')
    except (OSError, rosgraph.MasterException, xmlrpc.client.Error):
        pass  # rospy says itself that there is no master
    return None


def _remapped(topic):
    namespace = rosgraph.names.get_ros_namespace(argv=sys.argv)
    full = rosgraph.names.resolve_name(topic, namespace)
    for old, new in rosgraph.names.load_mappings(sys.argv).items():
        if rosgraph.names.resolve_name(old, namespace) == full:
            return rosgraph.names.resolve_name(new, namespace)
    return full


def _lives(master, node):
    """Return whether a node answers; what a crash has left registered does not."""
    try:
        uri = master.lookupNode(node)
    except rosgraph.MasterException:
        return False
    timeout = socket.getdefaulttimeout()
    socket.setdefaulttimeout(TIMEOUT)
    try:
        code, _, pid = xmlrpc.client.ServerProxy(uri).getPid('/robotont_gazebo')
        return code == 1 and pid != os.getpid()
    except (OSError, xmlrpc.client.Error):
        return False
    finally:
        socket.setdefaulttimeout(timeout)
