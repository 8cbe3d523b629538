"""Publishers for high rates and for the time of the shutdown, and a listener for new subscriptions."""
import contextlib
import socket
from typing import Any, Callable, Dict, Optional

import rospy

from rospy_support import rospy_internals
from rospy_support.rospy_internals import frame


class SubscriptionListener(rospy.SubscribeListener):
    """Calls ``on_subscribe()`` in one of rospy's threads at each new subscription; pass it to a Publisher."""

    def __init__(self, on_subscribe: Callable[[], Any]) -> None:
        super().__init__()
        self._on_subscribe = on_subscribe

    def peer_subscribe(self, topic_name: str, topic_publish: Any, peer_publish: Any) -> None:
        """Call ``on_subscribe``; rospy calls this method."""
        self._on_subscribe()


class Publisher(rospy.Publisher):
    """A rospy.Publisher that does nothing, instead of raising an error, once the node shuts down.

    rospy closes topics before it reports the shutdown, possibly in another thread.
    """

    def publish(self, *args: Any, **kwds: Any) -> None:
        """Publish a message, given as itself or by its fields."""
        try:
            super().publish(*args, **kwds)
        except Exception:  # any error: the shutdown may be closing the topic in another thread
            if not rospy_internals.shutting_down():
                raise


class LatestPublisher(rospy.Publisher):
    """A rospy.Publisher that writes at once, on the caller's thread, and never waits for a subscriber.

    rospy itself offers either one thread per connection (``queue_size``), which costs four times the CPU time at
    6,000 messages per second, or writing that blocks the whole node as soon as one subscriber stops reading.
    Here a subscriber that does not keep up loses messages, as with a queue of one in roscpp.

    Only one thread may publish at a time.
    """

    def __init__(self, name: str, data_class: Any,
                 subscriber_listener: Optional[rospy.SubscribeListener] = None) -> None:
        super().__init__(name, data_class, subscriber_listener, tcp_nodelay=True, queue_size=1)
        rospy_internals.publish_without_threads(self)
        self._published = 0
        self._unsent: Dict[Any, bytes] = {}  # connection -> rest of a message that was sent only in part

    def wanted(self) -> bool:
        """Return whether there are subscribers."""
        return bool(rospy_internals.connections(self))

    def publish(self, *args: Any, **kwds: Any) -> None:
        """Publish a message, given as itself or by its fields; once unregistered, do nothing."""
        data_class = self.data_class
        if data_class is not None:
            self._published += 1
            self.publish_frame(frame(rospy_internals.to_message(data_class, args, kwds), self._published))

    def publish_frame(self, data: bytes) -> None:
        """Publish a message that ``rospy_internals.frame`` has serialised."""
        connections = rospy_internals.connections(self)
        rospy_internals.count_publication(self)
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
            except (OSError, AttributeError):  # the subscriber has gone; the socket is None once rospy has closed it
                self._unsent.pop(connection, None)
                with contextlib.suppress(AttributeError, TypeError):  # another thread closes the topic: no more lists
                    connection.close()

    def _send_rest(self, connection: Any) -> None:
        """Send the rest of an incomplete message; the new message is dropped, so that the stream stays valid."""
        rest = self._unsent[connection]
        sent = connection.socket.send(rest, socket.MSG_DONTWAIT)
        if sent < len(rest):
            self._unsent[connection] = rest[sent:]
        else:
            del self._unsent[connection]
