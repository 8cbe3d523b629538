"""Replacements of the servers that every rospy node has, and limits for what its peers announce."""
import struct

import rosgraph.network
import rosgraph.xmlrpc
import rospy
import rospy.impl.tcpros_base
import rospy.impl.tcpros_service

from rospy_support.rospy_internals.services import handle_request


def replace_tcpros_server(start, stop):
    """Replace the loop that accepts the TCPROS connections of this process. Call it before init_node.

    rospy then calls ``start(listening socket, topic handler)`` and ``stop(listening socket)``. The topic handler takes
    (socket, address, header) of a connection; it writes rospy's header and returns None, or returns why it refuses.
    """
    class Server(rospy.impl.tcpros_base.TCPServer):
        def start(self):
            start(self.server_sock, self.inbound_handler.__self__.topic_connection_handler)

        def shutdown(self):
            if not self.is_shutdown:
                self.is_shutdown = True
                stop(self.server_sock)
    rospy.impl.tcpros_base.TCPServer = Server
    rospy.impl.tcpros_service.ServiceImpl._handle_request = handle_request


def replace_slave_server(make):
    """Use ``make(address, log_requests)`` to create the XML-RPC server of this process. Call it before init_node."""
    rosgraph.xmlrpc.ThreadingXMLRPCServer = make


def limit_lengths(header, message, report):
    """Close connections to publishers and services that announce too many bytes. Call it before init_node.

    ``header`` and ``message`` [bytes] are the largest sizes allowed; ``report(text)`` is called for a message that is
    larger.
    """
    base, client = rospy.impl.tcpros_base, rospy.impl.tcpros_service.TCPROSServiceClient

    def limited(read_messages, start):
        def read(self, buffer, queue, connection):
            if buffer.tell() >= start + 4:
                size = struct.unpack_from('<I', buffer.getbuffer(), start)[0]
                if size > message:
                    report(f'{self.resolved_name}: the other side announces {size} bytes, at most {message} are '
                           'allowed; the connection is closed.')
                    raise rospy.exceptions.TransportTerminated(f'a length of {size} bytes')
            return read_messages(self, buffer, queue, connection)
        return read

    def read_header(connection, buffer, size):
        return rosgraph.network.read_ros_handshake_header(_Limited(connection, header), buffer, size)
    base.TCPROSTransportProtocol.read_messages = limited(base.TCPROSTransportProtocol.read_messages, 0)
    client.read_messages = limited(client.read_messages, 1)  # after the byte that says whether the call succeeded
    base.read_ros_handshake_header = read_header


class _Limited:
    """Wraps a socket; raises ROSHandshakeException after ``left`` bytes."""

    def __init__(self, connection, left):
        self._connection, self._left = connection, left

    def recv(self, size):
        if self._left <= 0:
            raise rosgraph.network.ROSHandshakeException('the header is too long')
        data = self._connection.recv(size)
        self._left -= len(data)
        return data
