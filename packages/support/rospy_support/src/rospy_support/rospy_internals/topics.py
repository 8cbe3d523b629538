"""Topics: their connections and messages, and guards of the connections between publishers and subscribers."""
import contextlib
import errno
import functools
import io
import threading
from socket import socket as Socket
from typing import Any, Callable, Dict, FrozenSet, Iterable, List, Sequence, Set, Tuple

import rospy
import rospy.impl.masterslave
import rospy.msg
from rospy.impl.registration import RegManager, get_registration_listeners, get_topic_manager
from rospy.topics import _TopicImpl

HOLDER = '_holder'  # a field of connection headers, which attribute_connections sets, whatever the other side has sent


def connections(publisher: rospy.topics.Topic) -> Sequence[Any]:
    """Return the connections of a rospy.Publisher, empty once it is unregistered. Do not change the sequence.

    A connection has ``endpoint_id`` (the name of the subscribing node), ``socket`` (None once rospy has closed it)
    and ``close()``.
    """
    impl = publisher.impl  # another thread may call unregister, which sets it to None
    return impl.connections if impl else ()


def publish_without_threads(publisher: rospy.Publisher) -> None:
    """Let the publishing thread write to the connections of a Publisher, instead of one rospy thread for each."""
    publisher.impl.set_queue_size(None)


def caller(message: Any) -> str:
    """Return the name of the node that sent a message or a service request; '' if rospy does not know it."""
    return connection_header(message).get('callerid', '')


def connection_header(message: Any) -> Dict[str, str]:
    """Return the connection header {field: text} of the node that sent a message or a request: callerid, type, ..."""
    return getattr(message, '_connection_header', None) or {}


def holder(message: Any) -> str:
    """Return who holds the connection on which a message has arrived, see ``attribute_connections``; '' if unknown."""
    return connection_header(message).get(HOLDER, '')


def take_over(subscriber: rospy.Subscriber, message: Any, read: Callable[[Socket, bytes], Any]) -> None:
    """Let ``read(socket, bytes)`` read what follows a message on its connection to a rospy.Subscriber.

    rospy's thread for the connection calls it with a duplicate of the socket, which it closes, and the bytes that were
    already read after the message. When it returns, rospy continues, and notices when the connection is closed. Does
    nothing if rospy does not know the connection yet.
    """
    header = getattr(message, '_connection_header', None)
    for connection in connections(subscriber):
        if connection.header is header and 'receive_once' not in vars(connection):
            connection.receive_once = functools.partial(_taken_over, connection, read)


def _taken_over(connection: Any, read: Callable[[Socket, bytes], Any]) -> Any:
    buffer, own = connection.read_buff, connection.socket.dup()
    rest = buffer.getvalue()[:buffer.tell()]
    buffer.seek(0)
    buffer.truncate()
    read(own, rest)
    del connection.receive_once
    return connection.receive_once()


def to_message(data_class: Any, args: Any, kwds: Any) -> Any:
    """Return the message that the arguments of publish() stand for: either a message, or the fields of one."""
    return rospy.msg.args_kwds_to_message(data_class, args, kwds)


def to_bytes(message: Any) -> bytes:
    """Return the bytes of a message."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def frame(message: Any, seq: int = 0) -> bytes:
    """Return the bytes of a message on a TCPROS connection: its length, then its fields, with header.seq ``seq``."""
    buffer = io.BytesIO()
    rospy.msg.serialize_message(buffer, seq, message)
    return buffer.getvalue()


def publications() -> List[Any]:
    """Return [name, type] of each topic that this node publishes."""
    return get_topic_manager().get_publications()


def subscriptions() -> List[Any]:
    """Return [name, type] of each topic that this node subscribes to."""
    return get_topic_manager().get_subscriptions()


def unconnected_publications() -> Set[str]:
    """Return the names of the topics that this node publishes without a connected subscriber."""
    manager = get_topic_manager()
    return _unconnected(manager.get_publications(), manager.get_publisher_impl)


def count_publication(publisher: rospy.Publisher) -> None:
    """Count a message that did not go through the ``publish`` of a rospy.Publisher."""
    impl = publisher.impl
    if impl:
        impl.seq += 1


def published_messages() -> Dict[str, int]:
    """Return {topic: number of messages so far} for all topics of this node with a connected subscriber."""
    manager = get_topic_manager()
    found = [(name, manager.get_publisher_impl(name)) for name, _ in publications()]
    return {name: impl.seq for name, impl in found if impl is not None and impl.has_connections()}


def unconnected_subscriptions() -> Set[str]:
    """Return the names of the topics that this node subscribes to without a connected publisher."""
    manager = get_topic_manager()
    return _unconnected(manager.get_subscriptions(), manager.get_subscriber_impl)


def _unconnected(topics: Iterable[Any], implementation: Callable[[str], Any]) -> Set[str]:
    pairs = [(name, implementation(name)) for name, _ in topics]
    return {name for name, topic in pairs if topic is not None and not topic.has_connections()}


def new_publishers(topic: str, uris: Sequence[str]) -> None:
    """Connect the subscribers of a topic to these publishers, given by the URIs of their nodes."""
    for listener in get_registration_listeners().listeners:
        if isinstance(listener, RegManager):
            listener.publisher_update(topic, uris)


def limit_publishers() -> None:
    """Use one connecting thread per publisher of a topic, and end it when the master no longer lists the publisher.

    The fault: rospy starts another thread for a publisher at every update from the master, and each one retries for
    ever. Call it before init_node.
    """
    _Publishers().install()


class _Publishers:
    """Replacements for the functions of rospy that connect subscribers to publishers."""

    def __init__(self) -> None:
        self._named: Dict[str, FrozenSet[str]] = {}  # topic: URIs of the publishers in the last update from the master
        self._lock = threading.Lock()
        self._trying: Dict[Tuple[str, str], bool] = {}  # (topic, URI): whether it was listed again in the meantime
        self._own = threading.local()  # topic: the topic that this thread connects

    def install(self) -> None:
        update, connect = RegManager.publisher_update, RegManager._connect_topic_thread
        xmlrpcapi = rospy.impl.masterslave.xmlrpcapi
        RegManager.publisher_update = lambda *arguments: self._update(update, *arguments)
        RegManager._connect_topic_thread = lambda *arguments: self._connect(connect, *arguments)
        rospy.impl.masterslave.xmlrpcapi = lambda uri, cache=True: self._proxy(xmlrpcapi, uri, cache)

    def _update(self, update: Callable[..., Any], manager: Any, topic: str, uris: Sequence[str]) -> None:
        subscribed = get_topic_manager().has_subscription
        if subscribed(topic):
            self._named = {name: named for name, named in self._named.items() if subscribed(name)}
            self._named[topic] = frozenset(uris)
            update(manager, topic, uris)

    def _connect(self, connect: Callable[..., Any], manager: Any, topic: str, uri: str) -> None:
        with self._lock:
            once_more = (topic, uri) in self._trying
            self._trying[topic, uri] = once_more
        self._own.topic = topic
        while not once_more:
            connect(manager, topic, uri)
            with self._lock:
                if not self._trying[topic, uri]:
                    del self._trying[topic, uri]
                    return
                self._trying[topic, uri] = False

    def _proxy(self, xmlrpcapi: Callable[..., Any], uri: str, cache: bool) -> Any:
        if uri not in self._named.get(getattr(self._own, 'topic', ''), (uri,)):
            raise ConnectionRefusedError(errno.ECONNREFUSED, f'{uri} no longer publishes it')
        return xmlrpcapi(uri, cache)


def tell_connections_apart() -> None:
    """Let the topics of this process identify a connection by itself, not by the number of its file descriptor.

    The fault: the system reuses a number at once. A subscriber that returns while its old connection is being removed
    (rospy.wait_for_message in a loop) loses the new one, too, and waits forever.
    """
    _TopicImpl._remove_connection = _remove_connection
    _TopicImpl.check = functools.partialmethod(_locked, _TopicImpl.check)


def _remove_connection(self: Any, connections: List[Any], connection: Any) -> None:
    """Replace _TopicImpl._remove_connection: close a connection, and remove it or its queue from a list."""
    with contextlib.suppress(Exception):
        connection.close()
    connections[:] = [kept for kept in connections
                      if kept is not connection and getattr(kept, '_connection', None) is not connection]
    number = connection.fileno()
    if number is not None and all(kept.fileno() != number for kept in connections):
        with contextlib.suppress(Exception):  # the system has removed it if its number was in no use in between
            self.connection_poll.remove_fd(number)


def _locked(self: Any, check: Callable[[Any], Any]) -> None:
    """Replace _TopicImpl.check, which searches for broken connections before it takes the lock."""
    with self.c_lock:
        check(self)
