"""A node's TCPROS server: a SocketWatch reads the headers; rospy handles topics, ServiceConnection services.

The fault: rospy reads the header in the thread that accepts. One peer that connects and sends nothing, or a slow or
endless header, blocks all new subscribers and callers until it closes the connection.
"""
import struct
import threading
from socket import socket as Socket
from typing import Any, Callable, Dict, Optional

import rosgraph.network
from rosgraph.network import ROSHandshakeException

from rospy_support import rospy_internals
from rospy_support.inbound import Ended, Refused, SocketWatch, read_block
from rospy_support.service_connection import ServiceConnection

HEADER_LIMIT = 256 << 10  # [bytes]; a header contains the definition of the message type, up to 30 kB in known packages
HEADER_DEADLINE = 5.0  # [s] for a peer to send its header; ROS nodes send it at once

TopicHandler = Callable[[Socket, Any, Dict[str, str]], Optional[str]]  # (socket, address, header)


class TcprosServer:
    """Reads the header of each connection and passes the connection on."""

    def __init__(self, watch: SocketWatch, topic_handler: TopicHandler) -> None:
        """``topic_handler(socket, address, header)`` is rospy's; it returns the reason of a refusal, or None or ''."""
        self._watch, self._topic_handler = watch, topic_handler

    async def serve(self, connection: Socket, address: Any) -> None:
        """Read the header of a new connection and pass the connection on."""
        try:
            data = await self._watch.read(read_block(connection, HEADER_LIMIT), HEADER_DEADLINE)
            header = rosgraph.network.decode_ros_handshake_header(struct.pack('<I', len(data)) + data)
        except Ended:
            connection.close()
        except Refused as error:
            self._report(address, f'its header announces {error}')
            connection.close()
        except (ROSHandshakeException, struct.error, UnicodeDecodeError) as error:
            self._refuse(address, connection, f'its header cannot be read: {error}')
        else:
            await self._dispatch(address, connection, header)

    async def _dispatch(self, address: Any, connection: Socket, header: Dict[str, str]) -> None:
        if rospy_internals.shutting_down():
            _send_header(connection, {'error': 'node shutting down'})
            connection.close()
        elif 'topic' in header:
            threading.Thread(target=self._hand_over, args=(address, connection, header), daemon=True).start()
        elif 'service' in header:
            await self._serve_caller(address, connection, header)
        else:
            self._refuse(address, connection, 'no topic or service name detected')

    def _hand_over(self, address: Any, connection: Socket, header: Dict[str, str]) -> None:
        """Let rospy write its header and a latched message; runs in its own thread, since it may wait for the peer."""
        try:
            connection.setblocking(True)
            refused = self._topic_handler(connection, address, header)
        except Exception as error:  # usually the peer has gone; any other error ends only this connection, too
            self._report(address, f'{type(error).__name__}: {error}')
            connection.close()
            return
        if refused:
            self._refuse(address, connection, refused)

    async def _serve_caller(self, address: Any, connection: Socket, header: Dict[str, str]) -> None:
        try:
            service = rospy_internals.find_service(header)
        except LookupError as error:
            self._refuse(address, connection, str(error))
            return
        if not _send_header(connection, rospy_internals.service_header(service)) or header.get('probe') == '1':
            connection.close()
            return
        await ServiceConnection(self._watch, service, connection, header).serve()

    def _refuse(self, address: Any, connection: Socket, why: str) -> None:
        if not rospy_internals.shutting_down():
            self._report(address, why)
            _send_header(connection, {'error': why})
        connection.close()

    def _report(self, address: Any, why: str) -> None:
        self._watch.report('refused', f'Could not process inbound connection of {address[0]}: {why}')


def _send_header(connection: Socket, header: Dict[str, str]) -> bool:
    """Send a short header without waiting; return whether all of it was sent."""
    data = rosgraph.network.encode_ros_handshake_header(header)
    try:
        connection.setblocking(False)
        return connection.send(data) == len(data)
    except OSError:
        return False
