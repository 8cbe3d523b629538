"""Replacements of the servers that every rospy node has, and guards of the connections that it makes."""
import io
import struct
from socket import socket as Socket
from typing import Any, Callable, List, Optional

import rosgraph.xmlrpc
import rospy
import rospy.impl.tcpros_base
import rospy.impl.tcpros_service

from rospy_support.rospy_internals.services import handle_request
from rospy_support.rospy_internals.topics import HOLDER


def replace_tcpros_server(start: Callable[[Socket, Any], Any], stop: Callable[[Socket], Any]) -> None:
    """Replace the loop that accepts the TCPROS connections of this process. Call it before init_node.

    rospy then calls ``start(listening socket, topic handler)`` and ``stop(listening socket)``. The topic handler takes
    (socket, address, header) of a connection; it writes rospy's header and returns None, or returns why it refuses.
    """
    class Server(rospy.impl.tcpros_base.TCPServer):
        def start(self) -> None:
            start(self.server_sock, self.inbound_handler.__self__.topic_connection_handler)

        def shutdown(self) -> None:
            if not self.is_shutdown:
                self.is_shutdown: bool = True
                stop(self.server_sock)
    rospy.impl.tcpros_base.TCPServer = Server
    rospy.impl.tcpros_service.ServiceImpl._handle_request = handle_request


def replace_slave_server(make: Callable[..., Any]) -> None:
    """Use ``make(address, log_requests)`` to create the XML-RPC server of this process. Call it before init_node."""
    rosgraph.xmlrpc.ThreadingXMLRPCServer = make


def attribute_connections(holder: Callable[[Socket], str]) -> None:
    """Let ``holder(socket)`` say who holds the other end of each connection that this process makes by TCPROS.

    These lead to publishers and services. One for which it returns '' is closed; the ``holder(message)`` of this
    package returns the others.
    """
    transport = rospy.impl.tcpros_base.TCPROSTransport
    connect = transport.connect

    def attributed(self: Any, dest_addr: str, dest_port: int, endpoint_id: str,
                   timeout: Optional[float] = None) -> None:
        connect(self, dest_addr, dest_port, endpoint_id, timeout)  # ends when the other side has answered
        used = self.socket  # None: another thread has closed it meanwhile
        self.header[HOLDER] = holder(used) if used else ''
        if not self.header[HOLDER]:
            self.close()
            raise rospy.exceptions.TransportInitError('its address is that of a process of somebody else')
    transport.connect = attributed


def limit_messages(largest: int, report: Callable[[str], Any]) -> None:
    """Close connections to publishers that announce more than ``largest`` [bytes]. Call it before init_node.

    The fault: one publisher that announces 4 GB makes the node collect them. ``report(text)`` is called for each.
    """
    protocol = rospy.impl.tcpros_base.TCPROSTransportProtocol
    read_messages = protocol.read_messages

    def limited(self: Any, buffer: io.BytesIO, queue: List[Any], connection: Socket) -> Any:
        if buffer.tell() >= 4:
            size, = struct.unpack_from('<I', buffer.getbuffer())
            if size > largest:
                report(f'{self.resolved_name}: the other side announces {size} bytes, at most {largest} are allowed; '
                       'the connection is closed.')
                raise rospy.exceptions.TransportTerminated(f'a length of {size} bytes')
        return read_messages(self, buffer, queue, connection)
    protocol.read_messages = limited
