"""How far the nodes of this machine are behind a topic: the messages that lie unread in their sockets. Linux.

A node that gets no processor time does not read. How much waits for it is in the tables of TCP sockets (proc(5),
/proc/net/tcp), in the row of the node's end of the connection.
"""
from rospy_support import rospy_internals

TABLES = '/proc/net/tcp', '/proc/net/tcp6'


def unread(publisher, size):
    """Return {node: how many messages of ``size`` [bytes] it has not read} of a rospy.Publisher's local subscribers."""
    ports = {}
    for connection in list(rospy_internals.connections(publisher)):
        try:
            ports[connection.socket.getpeername()[1], connection.socket.getsockname()[1]] = connection.endpoint_id
        except (OSError, AttributeError):  # gone
            continue
    if not ports:
        return {}
    waiting = {}
    for path in TABLES:
        try:
            with open(path, encoding='ascii') as table:
                waiting.update(receive_queues(table))
        except OSError:  # no such table here
            continue
    return {node: waiting[pair] // size for pair, node in ports.items() if pair in waiting}


def receive_queues(table):
    """Return {(local port, remote port): bytes received and not read} of the lines of a table, its head first."""
    queues = {}
    for line in list(table)[1:]:
        _, local, remote, _, lengths = line.split()[:5]
        queues[_port(local), _port(remote)] = int(lengths.partition(':')[2], 16)
    return queues


def _port(address):
    return int(address.rpartition(':')[2], 16)
