"""A publisher for many small messages at a high rate, and a listener for those made only while somebody subscribes."""
import io
import socket

import rospy
import rospy.msg


def frame(message, seq=0):
    """Return a message, with header.seq ``seq``, as the bytes of a TCPROS connection: its length, then its fields."""
    buffer = io.BytesIO()
    rospy.msg.serialize_message(buffer, seq, message)
    return buffer.getvalue()


class SubscriptionListener(rospy.SubscribeListener):
    """Calls ``on_subscribe()`` in one of rospy's threads whenever somebody has subscribed; given to a Publisher."""

    def __init__(self, on_subscribe):
        super().__init__()
        self._on_subscribe = on_subscribe

    def peer_subscribe(self, topic_name, topic_publish, peer_publish):
        """Be rospy's callback."""
        self._on_subscribe()


def caller(message):
    """Return the name of the node that sent a message or a service request; '' where rospy does not know it."""
    return (getattr(message, '_connection_header', None) or {}).get('callerid', '')


class LatestPublisher(rospy.Publisher):
    """A rospy.Publisher that writes at once, on the caller's thread, and never waits for a subscriber.

    rospy itself offers either a thread a connection (``queue_size``), which costs four times the processor time
    at 6,000 messages a second, or writing that blocks the whole node as soon as one subscriber stops reading.
    Here a subscriber that does not keep up loses messages, as with a queue of one in roscpp.

    Only one thread may publish at a time.
    """

    def __init__(self, name, data_class):
        super().__init__(name, data_class, tcp_nodelay=True, queue_size=1)
        self.impl.set_queue_size(None)  # no thread a connection
        self._published = 0
        self._unsent = {}  # connection -> rest of a message that its socket took only in part

    def wanted(self):
        """Return whether anybody listens."""
        impl = self.impl  # unregister, in another thread, sets it to None
        return bool(impl and impl.connections)

    def publish(self, *args, **kwds):
        """Publish a message, given as itself or by its fields; once unregistered, do nothing."""
        data_class = self.data_class
        if data_class is not None:
            self._published += 1
            self.publish_frame(frame(rospy.msg.args_kwds_to_message(data_class, args, kwds), self._published))

    def publish_frame(self, data):
        """Publish a message that ``frame`` has serialised."""
        impl = self.impl
        if impl is None:
            return
        connections = impl.connections
        if self._unsent:  # rospy may have removed a connection itself
            self._unsent = {kept: rest for kept, rest in self._unsent.items() if kept in connections}
        for connection in connections:
            try:
                if connection not in self._unsent:
                    sent = connection.socket.send(data, socket.MSG_DONTWAIT)
                    if sent < len(data):
                        self._unsent[connection] = data[sent:]
                else:
                    self._send_rest(connection)
            except BlockingIOError:
                pass
            except (OSError, AttributeError):  # gone; its socket is None once rospy has closed it
                self._unsent.pop(connection, None)
                connection.close()

    def _send_rest(self, connection):
        """Complete a message sent in part; the present one is dropped, which keeps the stream whole."""
        rest = self._unsent[connection]
        sent = connection.socket.send(rest, socket.MSG_DONTWAIT)
        if sent < len(rest):
            self._unsent[connection] = rest[sent:]
        else:
            del self._unsent[connection]
