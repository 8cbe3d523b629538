"""A node's TCPROS server: a SocketWatch reads the headers; rospy handles topics, ServiceConnection services."""
import functools
import struct
import threading

import rosgraph.network
from rosgraph.network import ROSHandshakeException

from rospy_support import rospy_internals
from rospy_support.inbound import FrameReader, Refused
from rospy_support.service_connection import ServiceConnection

HEADER_LIMIT = 256 << 10  # [bytes]; a header contains the definition of the message type, up to 30 kB in known packages
HEADER_DEADLINE = 5.0  # [s] for a peer to send its header; ROS nodes send it at once


class TcprosServer:
    """Reads the header of each connection and passes the connection on."""

    def __init__(self, watch, topic_handler):
        """``topic_handler(socket, address, header)`` is rospy's; it returns why it refuses, or None or ''."""
        self._watch, self._topic_handler = watch, topic_handler

    def accepted(self, connection, address):
        """Read the header of a new connection."""
        self._watch.read(connection, FrameReader(HEADER_LIMIT), functools.partial(self._dispatch, address),
                         functools.partial(self._failed, address), HEADER_DEADLINE)

    def _failed(self, address, connection, error):
        if isinstance(error, Refused):
            self._report(address, f'its header announces {error}')
        connection.close()

    def _dispatch(self, address, connection, data):
        try:
            header = rosgraph.network.decode_ros_handshake_header(struct.pack('<I', len(data)) + data)
        except (ROSHandshakeException, struct.error, UnicodeDecodeError) as error:
            self._refuse(address, connection, f'its header cannot be read: {error}')
            return
        if rospy_internals.shutting_down():
            _send_header(connection, {'error': 'node shutting down'})
            connection.close()
        elif 'topic' in header:
            threading.Thread(target=self._hand_over, args=(address, connection, header), daemon=True).start()
        elif 'service' in header:
            self._serve(address, connection, header)
        else:
            self._refuse(address, connection, 'no topic or service name detected')

    def _hand_over(self, address, connection, header):
        """Let rospy write its header and a latched message; runs in its own thread, as it may wait for the peer."""
        try:
            connection.setblocking(True)
            refused = self._topic_handler(connection, address, header)
        except Exception as error:  # usually the peer has gone; any other error ends only this connection, too
            self._report(address, f'{type(error).__name__}: {error}')
            connection.close()
            return
        if refused:
            self._refuse(address, connection, refused)

    def _serve(self, address, connection, header):
        service, refused = rospy_internals.find_service(header)
        if service is None:
            self._refuse(address, connection, refused)
            return
        if not _send_header(connection, rospy_internals.service_header(service)) or header.get('probe') == '1':
            connection.close()
            return
        ServiceConnection(self._watch, service, connection, header).open(connection)

    def _refuse(self, address, connection, why):
        if not rospy_internals.shutting_down():
            self._report(address, why)
            _send_header(connection, {'error': why})
        connection.close()

    def _report(self, address, why):
        self._watch.report('refused', f'Could not process inbound connection of {address[0]}: {why}')


def _send_header(connection, header):
    """Send a short header without waiting; return whether all of it was sent."""
    data = rosgraph.network.encode_ros_handshake_header(header)
    try:
        connection.setblocking(False)
        return connection.send(data) == len(data)
    except OSError:
        return False
