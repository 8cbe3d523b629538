"""There is one robot a namespace: a second one is told before it disturbs the first."""
import sys
import xmlrpc.client

import rosgraph
import rosgraph.names

from ros_doctor import registrations

TIMEOUT = 2.0  # [s] for a node to say that it lives


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
    """End this process with a text where another robot has its name or publishes its topic; call it before rospy."""
    other = other_robot(node, topic)
    if other:
        sys.exit(f'{node} does not start: {other}')


def other_robot(node, topic):
    """Return a text about a living node of the name ``node`` or one that publishes ``topic``, or None.

    rospy is not initialised yet: a node of the same name would be shut down by that.
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
        pass  # rospy says itself that there is no master
    return None


def _lives(master, node):
    """Return whether a node answers by its name; what an end has left registered does not, whoever has its port now."""
    service = rosgraph.names.ns_join(node, registrations.SIGN)
    try:
        return registrations.offers(service, master.lookupService(service), TIMEOUT)
    except rosgraph.MasterException:
        return False
