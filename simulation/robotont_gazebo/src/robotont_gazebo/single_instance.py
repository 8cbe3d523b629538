"""Refuse to start a second robot in a namespace, before it disturbs the first one."""
import sys
import xmlrpc.client

import rosgraph
import rosgraph.names

from plain_support.doctor import registrations

TIMEOUT = 2.0  # [s] in which a running node must answer


def resolved(name):
    """Return the full name of a topic or node of this process, from the command line and the environment."""
    mappings = rosgraph.names.load_mappings(sys.argv)
    namespace = rosgraph.names.get_ros_namespace(argv=sys.argv)
    full = rosgraph.names.ns_join(namespace, name)
    for old, new in mappings.items():
        if rosgraph.names.ns_join(namespace, old) == full:
            return rosgraph.names.ns_join(namespace, new)
    return full


def require_alone(node, topic):
    """End this process with a text if another robot has its name or publishes its topic; call it before init_node."""
    other = other_robot(node, topic)
    if other:
        sys.exit(f'{node} does not start: {other}')


def other_robot(node, topic):
    """Return a text about a running node that is called ``node`` or publishes ``topic``; None if there is none.

    rospy must not be initialised yet, because that shuts down a node with the same name.
    """
    own = resolved(rosgraph.names.load_mappings(sys.argv).get('__name', node))
    published = resolved(topic)
    master = rosgraph.Master(own)
    try:
        publishers = dict(master.getSystemState()[0]).get(published, [])
        for name in sorted({own, *publishers}):
            if _lives(master, name):
                what = 'has this name' if name == own else f'publishes {published}'
                return (f'{name} {what} already: two robots would use the same topics. Stop that node, or start this '
                        f'one in its own namespace, e.g. __ns:=robot2')
    except (OSError, rosgraph.MasterException, xmlrpc.client.Error):
        pass  # rospy itself reports that there is no master
    return None


def _lives(master, node):
    """Return whether a node answers with its own name; one that has ended does not, even if its port is reused."""
    service = rosgraph.names.ns_join(node, registrations.SIGN)
    try:
        return registrations.offers(service, master.lookupService(service), TIMEOUT)
    except rosgraph.MasterException:
        return False
