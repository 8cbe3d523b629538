"""The only module that touches private parts of rospy; checked against rospy 1.15, 1.16, 1.17.

All other modules use only the documented API of rospy. ``misfits()`` lists what differs in another version of rospy,
and the unit test of this module fails with that list. student_path/sitecustomize.py replaces
``rospy.impl.simtime.init_simtime`` in a student's program, where this package is not available; the list covers what
it uses, too.
"""
import contextlib
import errno
import functools
import importlib
import importlib.metadata
import inspect
import io
import re
import select
import socket
import struct
import sys
import threading
import time
import types
import xmlrpc.client

import genpy
import rosgraph
import rosgraph.network
import rosgraph.roslogging
import rosgraph.xmlrpc
import rospy
import rospy.client
import rospy.core
import rospy.impl.init
import rospy.impl.masterslave
import rospy.impl.paramserver
import rospy.impl.simtime
import rospy.impl.tcpros_base
import rospy.impl.tcpros_service
import rospy.msg
import rospy.rostime
from rospy.impl.registration import (
    Registration,
    RegManager,
    get_registration_listeners,
    get_service_manager,
    get_topic_manager,
)
from rospy.impl.statistics import SubscriberStatisticsLogger
from rospy.topics import _TopicImpl

from rospy_support.limited_transport import LimitedTransport

CHECKED = '1.15', '1.16', '1.17'  # versions of rospy
LOG_PARAMETER = '/rosout_disable_topics_generation'  # true: messages on /rosout do not list the node's topics
ANY_TYPE = '*'  # instead of an md5sum: matches every type
STATISTICS_PARAMETER = '/enable_statistics'  # true: subscribers publish statistics of what they receive
REGISTRATION_POLL = 0.005  # [s]; a master answers in 3 ms
SHUTDOWN_POLL = 0.5  # [s] between two checks whether a call can still be answered

FUNCTIONS = {  # functions that this module calls or replaces: names of their parameters
    'rosgraph.roslogging.configure_logging': ('logname', 'level', 'filename', 'env'),
    'rospy.client.load_command_line_node_params': ('argv',),
    'rospy.core.is_shutdown': (),
    'rospy.core.is_shutdown_requested': (),
    'rospy.impl.masterslave.ROSHandler.shutdown': ('args', 'kwds'),  # the signature of its decorator
    'rospy.impl.paramserver.get_param_server_cache': (),
    'rospy.impl.paramserver.ParamServerCache.set': ('self', 'key', 'value'),
    'rospy.impl.registration.get_registration_listeners': (),
    'rospy.impl.statistics.SubscriberStatisticsLogger.is_enabled': (),
    'rospy.impl.statistics.SubscriberStatisticsLogger.__init__': ('self', 'subscriber'),
    'rospy.impl.registration.RegManager.publisher_update': ('self', 'resolved_name', 'uris'),
    'rospy.impl.registration.RegManager._connect_topic_thread': ('self', 'topic', 'uri'),
    'rospy.impl.masterslave.ROSHandler.publisherUpdate': ('args', 'kwds'),  # the signature of its decorator
    'rospy.impl.masterslave.xmlrpcapi': ('uri', 'cache'),
    'rospy.topics._TopicManager.has_subscription': ('self', 'resolved_name'),
    'rospy.msg.args_kwds_to_message': ('data_class', 'args', 'kwds'),
    'rospy.msg.serialize_message': ('b', 'seq', 'msg'),
    'rospy.rostime._set_rostime': ('t',),
    'rospy.rostime.get_rostime_cond': (),
    'rospy.rostime.is_wallclock': (),
    'rospy.impl.simtime.init_simtime': (),
    'rospy.impl.registration.get_topic_manager': (),
    'rospy.impl.registration.get_service_manager': (),
    'rospy.impl.registration.RegistrationListeners.notify_added': ('self', 'resolved_name', 'data_type', 'reg_type'),
    'rospy.impl.registration.RegistrationListeners.notify_removed': ('self', 'resolved_name', 'data_type_or_uri',
                                                                     'reg_type'),
    'rospy.topics._TopicManager._recalculate_topics': ('self',),
    'rospy.topics._TopicManager.get_publications': ('self',),
    'rospy.topics._TopicManager.get_subscriptions': ('self',),
    'rospy.topics._TopicManager.get_publisher_impl': ('self', 'resolved_name'),
    'rospy.topics._TopicManager.get_subscriber_impl': ('self', 'resolved_name'),
    'rospy.topics._TopicImpl.has_connections': ('self',),
    'rospy.topics._TopicImpl._remove_connection': ('self', 'connections', 'c'),
    'rospy.topics._TopicImpl.check': ('self',),
    'rospy.topics._PublisherImpl.set_queue_size': ('self', 'queue_size'),
    'rospy.service.ServiceManager.get_services': ('self',),
    'rospy.service.ServiceManager.get_service': ('self', 'resolved_service_name'),
    'rospy.impl.tcpros_service.convert_return_to_response': ('response', 'response_class'),
    'rospy.impl.tcpros_service.ServiceImpl._handle_request': ('self', 'transport', 'request'),
    'rospy.impl.tcpros_service.ServiceImpl.error_handler': ('self', 'e', 'exc_type', 'exc_value', 'tb'),
    'rospy.impl.tcpros_service.TCPService.get_header_fields': ('self',),
    'rospy.impl.tcpros_service.TCPROSServiceClient.read_messages': ('self', 'b', 'msg_queue', 'sock'),
    'rospy.impl.tcpros_base.TCPServer.__init__': ('self', 'inbound_handler', 'port'),
    'rospy.impl.tcpros_base.TCPServer.start': ('self',),
    'rospy.impl.tcpros_base.TCPServer.shutdown': ('self',),
    'rospy.impl.tcpros_base.TCPROSServer._tcp_server_callback': ('self', 'sock', 'client_addr'),
    'rospy.impl.tcpros_base.TCPROSTransport.__init__': ('self', 'protocol', 'name', 'header'),
    'rospy.impl.tcpros_base.TCPROSTransport.set_socket': ('self', 'sock', 'endpoint_id'),
    'rospy.impl.tcpros_base.TCPROSTransport.close': ('self',),
    'rospy.impl.tcpros_base.TCPROSTransport.receive_once': ('self',),
    'rospy.impl.tcpros_base.TCPROSTransport.receive_loop': ('self', 'msgs_callback'),
    'rospy.impl.tcpros_base.TCPROSTransportProtocol.read_messages': ('self', 'b', 'msg_queue', 'sock'),
    'rospy.impl.tcpros_base.read_ros_handshake_header': ('sock', 'b', 'buff_size'),
    'rospy.impl.tcpros_pubsub.TCPROSHandler.topic_connection_handler': ('self', 'sock', 'client_addr', 'header'),
    'rosgraph.xmlrpc.ThreadingXMLRPCServer.__init__': ('self', 'addr', 'log_requests'),
}
ATTRIBUTES = {  # classes: attributes that their constructors set
    'rospy.topics.Topic': ('impl',),
    'rospy.topics._TopicImpl': ('connection_poll', 'connections', 'c_lock'),
    'rospy.topics._TopicManager': ('lock', 'pubs', 'subs'),
    'rospy.topics.Poller': ('poller',),
    'rospy.impl.registration.RegistrationListeners': ('listeners',),
    'rospy.impl.tcpros_base.TCPROSTransport': ('socket', 'endpoint_id', 'header', 'read_buff'),
    'rospy.impl.tcpros_base.TCPServer': ('server_sock', 'inbound_handler', 'is_shutdown'),
    'rospy.impl.tcpros_base.TCPROSServer': ('topic_connection_handler',),
    'rospy.impl.tcpros_pubsub.QueuedConnection': ('_connection',),
    'rospy.impl.tcpros_service.ServiceImpl': ('handler', 'seq', 'protocol'),
    'rospy.service._Service': ('resolved_name', 'service_class', 'request_class', 'response_class'),
}
OBJECTS = (  # other objects that this module uses
    'rospy.core._shutdown_flag', 'rospy.core._shutdown_lock.acquire', 'rospy.core._xmlrpc_cache.get',
    'rospy.impl.init.time.sleep')


def connections(publisher):
    """Return the connections of a rospy.Publisher; none once it is unregistered. Do not change the sequence.

    A connection has ``endpoint_id`` (the name of the subscribing node), ``socket`` (None once rospy has closed it)
    and ``close()``.
    """
    impl = publisher.impl  # another thread may call unregister, which sets it to None
    return impl.connections if impl else ()


def publish_without_threads(publisher):
    """Let the publishing thread write to the connections of a Publisher, instead of one rospy thread for each."""
    publisher.impl.set_queue_size(None)


def caller(message):
    """Return the name of the node that sent a message or a service request; '' if rospy does not know it."""
    return connection_header(message).get('callerid', '')


def connection_header(message):
    """Return the connection header {field: text} of the node that sent a message or a request: callerid, type, ..."""
    return getattr(message, '_connection_header', None) or {}


def take_over(subscriber, message, read):
    """Let ``read(socket, bytes)`` take what comes after a message by the same connection of a rospy.Subscriber.

    It is called in rospy's thread for the connection, with a socket of its own, which it closes, and what has been read
    after the message; when it returns, rospy goes on, and notices when the connection is closed. Does nothing if rospy
    does not know the connection yet.
    """
    header = getattr(message, '_connection_header', None)
    for connection in connections(subscriber):
        if connection.header is header and 'receive_once' not in vars(connection):
            connection.receive_once = functools.partial(_taken_over, connection, read)


def _taken_over(connection, read):
    buffer, own = connection.read_buff, connection.socket.dup()
    rest = buffer.getvalue()[:buffer.tell()]
    buffer.seek(0)
    buffer.truncate()
    read(own, rest)
    del connection.receive_once
    return connection.receive_once()


def to_message(data_class, args, kwds):
    """Return the message that the arguments of publish() stand for: either a message, or the fields of one."""
    return rospy.msg.args_kwds_to_message(data_class, args, kwds)


def frame(message, seq=0):
    """Return the bytes of a message on a TCPROS connection: its length, then its fields, with header.seq ``seq``."""
    buffer = io.BytesIO()
    rospy.msg.serialize_message(buffer, seq, message)
    return buffer.getvalue()


def set_time(now):
    """Set the ROS time of this process, as a message on /clock does; ``now`` is a rospy.Time."""
    rospy.rostime._set_rostime(now)


def follow_time():
    """Take the time from /clock if /use_sim_time is true, else from the wall clock. Return whether that worked.

    init_node does the same, unless it is called with ``disable_rostime``.
    """
    return rospy.impl.simtime.init_simtime()


def is_wall_time():
    """Return whether rospy takes its time from the wall clock."""
    return rospy.rostime.is_wallclock()


def publications():
    """Return [name, type] of each topic that this node publishes."""
    return get_topic_manager().get_publications()


def subscriptions():
    """Return [name, type] of each topic that this node subscribes to."""
    return get_topic_manager().get_subscriptions()


def services():
    """Return (name, URI) of each service that this node offers."""
    return get_service_manager().get_services()


def unconnected_publications():
    """Return the names of the topics that this node publishes without a connected subscriber."""
    manager = get_topic_manager()
    return _unconnected(manager.get_publications(), manager.get_publisher_impl)


def connected_publications():
    """Return the names of the topics that this node publishes with a connected subscriber."""
    return {name for name, _ in publications()} - unconnected_publications()


def unconnected_subscriptions():
    """Return the names of the topics that this node subscribes to without a connected publisher."""
    manager = get_topic_manager()
    return _unconnected(manager.get_subscriptions(), manager.get_subscriber_impl)


def find_service(header):
    """Return (service, '') for the service that a caller's header {field: text} names, or (None, reason).

    A service has ``resolved_name`` and ``request_class``; see also ``service_header`` and ``respond``.
    """
    for field in ('md5sum', 'callerid'):
        if field not in header:
            return None, f"Missing required '{field}' field"
    found = get_service_manager().get_service(header['service'])
    if found is None:
        return None, f'[{rospy.get_name()}] is not a provider of [{header["service"]}]'
    if header['md5sum'] not in (ANY_TYPE, found.service_class._md5sum):
        return None, (f'request from [{header["callerid"]}]: md5sums do not match: [{header["md5sum"]}] vs. '
                      f'[{found.service_class._md5sum}]')
    return found, ''


def service_header(found):
    """Return the header {field: text} with which a service answers the header of its caller."""
    return found.protocol.get_header_fields()


def transport_of(found, connection, header):
    """Return rospy's transport for a connection (socket) to a service; ``header`` {field: text} is the caller's."""
    transport = rospy.impl.tcpros_base.TCPROSTransport(found.protocol, found.resolved_name, header=header)
    transport.set_socket(connection, header['callerid'])
    return transport


def respond(found, transport, data):
    """Call a service with a serialised request and write the answer; raise OSError if the caller has gone.

    ``data`` (bytes) must have the length of a request: see ``message_size.wrong_size``.
    """
    request = found.request_class()
    try:
        request.deserialize(data)
    except genpy.DeserializationError as error:
        transport.socket.sendall(service_error(f'a request of {request._type} cannot be read: {error}'))
        return
    request._connection_header = transport.header
    found._handle_request(transport, request)


def _handle_request(self, transport, request):
    """Replace ServiceImpl._handle_request, which reports a caller that has gone as an error of the handler."""
    try:
        response = rospy.impl.tcpros_service.convert_return_to_response(self.handler(request), self.response_class)
        self.seq += 1
        answer = b'\1' + frame(response, self.seq)
    except rospy.ServiceException as error:
        answer = service_error(f'service cannot process request: {error}')
    except Exception as error:
        self.error_handler(error, *sys.exc_info())
        answer = service_error(f'error processing request: {error}')
    transport.socket.sendall(answer)


def service_error(text):
    """Return the bytes of an answer that makes the caller raise a ServiceException with this text."""
    data = text.encode()
    return struct.pack('<BI', 0, len(data)) + data


def is_shutdown_requested():
    """Return whether this node is about to end."""
    return rospy.core.is_shutdown_requested()


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
    rospy.impl.tcpros_service.ServiceImpl._handle_request = _handle_request


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


def limit_publishers(most):
    """Use one connecting thread per publisher of a topic, and end it when the master no longer lists the publisher.

    rospy starts another thread for a publisher at every update from the master, and each one retries forever.
    Of each update, only the first ``most`` publishers are used. Call it before init_node.
    """
    _Publishers(most).install()


class _Publishers:
    """Replacements for the functions of rospy that connect subscribers to publishers."""

    def __init__(self, most):
        self._most = most
        self._named = {}  # topic: URIs of the publishers in the last update from the master
        self._lock, self._trying = threading.Lock(), {}  # (topic, URI): whether it was listed again in the meantime
        self._own = threading.local()  # topic: the topic that this thread connects

    def install(self):
        handler, manager = rospy.impl.masterslave.ROSHandler, RegManager
        told, update, connect = handler.publisherUpdate, manager.publisher_update, manager._connect_topic_thread
        xmlrpcapi = rospy.impl.masterslave.xmlrpcapi
        handler.publisherUpdate = lambda *arguments: told(*self._shortened(arguments))
        manager.publisher_update = lambda *arguments: self._update(update, *arguments)
        manager._connect_topic_thread = lambda *arguments: self._connect(connect, *arguments)
        rospy.impl.masterslave.xmlrpcapi = lambda uri, cache=True: self._proxy(xmlrpcapi, uri, cache)

    def _shortened(self, arguments):
        return [each[:self._most] if isinstance(each, list) else each for each in arguments]

    def _update(self, update, manager, topic, uris):
        subscribed = get_topic_manager().has_subscription
        if subscribed(topic):
            self._named = {name: named for name, named in self._named.items() if subscribed(name)}
            self._named[topic] = frozenset(uris)
            update(manager, topic, uris)

    def _connect(self, connect, manager, topic, uri):
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

    def _proxy(self, xmlrpcapi, uri, cache):
        if uri not in self._named.get(getattr(self._own, 'topic', None), (uri,)):
            raise ConnectionRefusedError(errno.ECONNREFUSED, f'{uri} no longer publishes it')
        return xmlrpcapi(uri, cache)


def tell_connections_apart():
    """Let the topics of this process remove a connection, not what now has its file descriptor's number.

    rospy compares these numbers, and the system gives each one again at once. So a subscriber that came back while its
    old connection was being removed (rospy.wait_for_message in a loop) lost the new one, too, and waited for ever.
    """
    _TopicImpl._remove_connection = _remove_connection
    _TopicImpl.check = functools.partialmethod(_locked, _TopicImpl.check)


def _remove_connection(self, connections, connection):
    """Replace _TopicImpl._remove_connection: close a connection, and remove it or its queue from a list."""
    with contextlib.suppress(Exception):
        connection.close()
    connections[:] = [kept for kept in connections
                      if kept is not connection and getattr(kept, '_connection', None) is not connection]
    number = connection.fileno()
    if number is not None and all(kept.fileno() != number for kept in connections):
        with contextlib.suppress(Exception):  # the system has removed it if its number was in no use in between
            self.connection_poll.remove_fd(number)


def _locked(self, check):
    """Replace _TopicImpl.check, which looks for broken connections before it takes the lock."""
    with self.c_lock:
        check(self)


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


def _unconnected(topics, implementation):
    pairs = [(name, implementation(name)) for name, _ in topics]
    return {name for name, topic in pairs if topic is not None and not topic.has_connections()}


def command_line_parameters(argv=None):
    """Return {absolute name: value} of the private parameters given as _name:=value on the command line."""
    given = rospy.client.load_command_line_node_params(sys.argv if argv is None else argv)
    return {rospy.resolve_name(f'~{name}'): value for name, value in given.items()}


def poll_for_registration():
    """Let init_node look every REGISTRATION_POLL whether the master has answered; rospy does every 0.1 s."""
    rospy.impl.init.time = types.SimpleNamespace(sleep=lambda seconds: time.sleep(min(seconds, REGISTRATION_POLL)))


def log_without_asking():
    """Keep log calls from asking the master for LOG_PARAMETER; ask for it once. Call it after init_node.

    While LOG_PARAMETER is not set, rospy asks for it at each log line and subscribes to it. That has four drawbacks: it
    takes time; a master that hangs blocks the node; a restarted master seems to know the node; and a master still
    lists the node after its end, and would send a shutdown request to the next owner of its port.
    """
    try:
        value = rospy.get_param(LOG_PARAMETER, False)
    except (OSError, xmlrpc.client.Error):
        value = False
    rospy.impl.paramserver.get_param_server_cache().set(LOG_PARAMETER, value)


def new_publishers(topic, uris):
    """Connect the subscribers of a topic to these publishers, given by the URIs of their nodes."""
    for listener in get_registration_listeners().listeners:
        if isinstance(listener, RegManager):
            listener.publisher_update(topic, uris)


def shutting_down():
    """Return whether the shutdown has started; rospy.is_shutdown() is true only after some hooks have run."""
    return rospy.core.is_shutdown_requested() or rospy.core.is_shutdown()


def limit_calls_of_master(seconds):
    """Limit the time [s] that rospy waits for the master. Call it at the shutdown, which unregisters the node.

    The shutdown then has a connection of its own, so that it does not wait for another thread's call of the master.
    """
    uri = rosgraph.get_master_uri()
    rospy.core._xmlrpc_cache[uri] = xmlrpc.client.ServerProxy(uri, transport=_ShutdownTransport(seconds))


class _ShutdownTransport(LimitedTransport):
    """A connection for each call; raises ProtocolError for the OSErrors that rospy's shutdown does not handle."""

    def request(self, host, *arguments, **options):
        try:
            with contextlib.closing(LimitedTransport(self.limit)) as own:  # another thread may be calling, too
                return own.request(host, *arguments, **options)
        except OSError as error:
            raise xmlrpc.client.ProtocolError(host, 0, str(error), {}) from None


def end_registering(timeout):
    """End a registration that has not succeeded after ``timeout`` [s], because the shutdown needs its lock.

    While no master answers, rospy retries until it shuts down, and holds that lock all the time.
    """
    for manager in (get_topic_manager(), get_service_manager()):
        if manager.lock.acquire(timeout=timeout):
            manager.lock.release()
        else:
            rospy.core._shutdown_flag = True


def wait_for_shutdown():
    """Wait until rospy.signal_shutdown has called all hooks, if another thread is executing it."""
    with rospy.core._shutdown_lock:
        pass


def shut_down_by(function):
    """Call ``function(reason)`` when the master or another node (rosnode kill) requests a shutdown, and answer them.

    A request for another node is ignored: a master that does not know of that node's end sends it to the present
    owner of the port.
    """
    def shutdown(self, caller_id, msg=''):
        print(f'shutdown request: {msg}')
        meant = re.match(r'\[(/\S*)\] Reason: ', str(msg))  # a master begins with the name of the node
        if meant and meant.group(1) != self.name:
            rospy.logwarn('Ignored a shutdown request for %s', meant.group(1))
            return 0, f'this is {self.name}', 0
        function(f'external shutdown request from [{caller_id}]: [{msg}]')
        return 1, 'shutdown', 0
    rospy.impl.masterslave.ROSHandler.shutdown = shutdown


@contextlib.contextmanager
def logging_configured_by(function):
    """In this context, rospy.init_node configures logging by ``function(original, *arguments, **options)``."""
    original = rosgraph.roslogging.configure_logging
    rosgraph.roslogging.configure_logging = functools.partial(function, original)
    try:
        yield
    finally:
        rosgraph.roslogging.configure_logging = original


class ServiceCall:
    """A request of a QueuedService. Call either ``answer`` or ``fail``, once, from any thread."""

    def __init__(self, service, transport, request):
        self.service, self.request = service, request
        self._transport = transport
        self._unsent = b''
        self._answered = threading.Event()

    def answer(self, response):
        """Send a response without waiting for a client that does not read."""
        self._write(b'\x01' + frame(response))

    def fail(self, reason):
        """Send the reason of a failure, also without waiting."""
        self._write(service_error(reason))

    def _write(self, data):
        connection = self._transport.socket
        try:
            taken = select.poll()
            taken.register(connection, select.POLLOUT)
            # send() on a socket with a timeout waits despite MSG_DONTWAIT
            sent = connection.send(data, socket.MSG_DONTWAIT) if taken.poll(0) else 0
        except BlockingIOError:
            sent = 0
        except (OSError, TypeError, AttributeError):  # the client has gone; the socket is None once rospy has closed it
            sent = len(data)
        self._unsent = data[sent:]
        self._answered.set()

    def finish(self):
        """Wait for the answer, and send what is left of it. The thread of the connection calls this."""
        while not self._answered.wait(SHUTDOWN_POLL):
            if rospy.is_shutdown():
                return
        if self._unsent:
            self._transport.socket.sendall(self._unsent)


class QueuedService(rospy.Service):
    """A rospy.Service that passes its requests on as ServiceCalls instead of answering them itself."""

    def __init__(self, name, service_class, hand_over):
        """``hand_over(call)`` is called in one of rospy's threads, which then waits until the call is answered."""
        self._hand_over = hand_over
        super().__init__(name, service_class, hand_over)

    def _handle_request(self, transport, request):
        call = ServiceCall(self, transport, request)
        self._hand_over(call)
        call.finish()


class _ConnectionPoll:
    """Replaces rospy's poller of broken connections, which takes a file descriptor for each topic."""

    def __init__(self):
        self._lock = threading.Lock()  # two threads cannot use select.poll at the same time
        self._poll = select.poll()
        self._files = set()

    def add_fd(self, file):
        """Watch a connection."""
        with self._lock:
            self._poll.register(file, 0)  # POLLHUP and POLLERR are always reported
            self._files.add(file)

    def remove_fd(self, file):
        """Stop watching a connection; raise KeyError if it was not watched."""
        with self._lock:
            self._poll.unregister(file)
            self._files.remove(file)

    def error_iter(self):
        """Return the broken connections."""
        if not self._files:
            return ()
        with self._lock:
            return [file for file, event in self._poll.poll(0) if event]


_collecting = threading.local()  # calls: the list that this thread collects, else None or missing


@contextlib.contextmanager
def collected_registrations():
    """Collect the registrations that this thread makes as a list of calls; none is sent to the master.

    A call is a tuple: a method of the master's XML-RPC interface, then its arguments after the caller's name.
    """
    _divert(get_registration_listeners())
    _collecting.calls = calls = []
    try:
        yield calls
    finally:
        _collecting.calls = None
    manager = get_topic_manager()
    with manager.lock:  # rospy holds it when it goes through all topics
        for method, name, *_ in calls:
            topic = (manager.pubs if method == 'registerPublisher' else manager.subs).get(name)
            if topic and method != 'registerService':
                topic.connection_poll.poller.close()
                topic.connection_poll = _ConnectionPoll()
    calls.append(('getParam', STATISTICS_PARAMETER))  # rospy reads it for each subscriber; here once for all


def registered(calls, values):
    """Process the master's answers to the calls of collected_registrations, as rospy does; None: a refused call."""
    for (method, name, *_), value in zip(calls, values):
        if method == 'registerSubscriber':
            if value:
                new_publishers(name, value)
            if values[-1]:
                topic = get_topic_manager().subs[name]
                topic.statistics_logger = SubscriberStatisticsLogger(topic)


@contextlib.contextmanager
def collected_unregistrations():
    """Collect what this thread unregisters, as collected_registrations does; many topics take no longer than one."""
    _divert(get_registration_listeners())
    manager = get_topic_manager()
    _collecting.calls = calls = []
    with manager.lock:
        manager._recalculate_topics = lambda: None  # rospy goes through all topics each time it removes one
        try:
            yield calls
        finally:
            _collecting.calls = None
            del manager._recalculate_topics
            manager._recalculate_topics()


def _divert(listeners):
    """Make rospy collect its calls of the master in a thread that collects, and send them in all others."""
    if 'notify_added' in vars(listeners):
        return
    tell_added, tell_removed = listeners.notify_added, listeners.notify_removed
    statistics_wanted = SubscriberStatisticsLogger.is_enabled

    def added(name, type_or_uri, kind):
        if getattr(_collecting, 'calls', None) is None:
            tell_added(name, type_or_uri, kind)
        else:
            _collecting.calls.append((f'register{_KINDS[kind]}', name, type_or_uri, rospy.get_node_uri()))

    def removed(name, type_or_uri, kind):
        if getattr(_collecting, 'calls', None) is None:
            tell_removed(name, type_or_uri, kind)
        else:
            uri = type_or_uri if kind == Registration.SRV else rospy.get_node_uri()
            _collecting.calls.append((f'unregister{_KINDS[kind]}', name, uri))
    listeners.notify_added, listeners.notify_removed = added, removed
    SubscriberStatisticsLogger.is_enabled = lambda: getattr(_collecting, 'calls', None) is None and statistics_wanted()


_KINDS = {Registration.PUB: 'Publisher', Registration.SUB: 'Subscriber', Registration.SRV: 'Service'}


def version():
    """Return the version of rospy; '?' if its installation does not tell."""
    try:
        return importlib.metadata.version('rospy')
    except importlib.metadata.PackageNotFoundError:
        return '?'


def misfits():
    """Return one line for each private part of rospy that differs from what this module needs; [] if none does."""
    return ([said for name, parameters in FUNCTIONS.items() for said in _wrong_function(name, parameters)]
            + [said for name, attributes in ATTRIBUTES.items() for said in _wrong_class(name, attributes)]
            + [f'{name} is missing' for name in OBJECTS if not _there(name)])


def _there(name):
    try:
        _part(name)
    except (AttributeError, ImportError):
        return False
    return True


def _wrong_function(name, parameters):
    try:
        found = tuple(inspect.signature(_part(name)).parameters)
    except (AttributeError, ImportError, TypeError, ValueError):
        return [f'{name} is missing']
    return [] if found == parameters else [f'{name} takes ({", ".join(found)}), not ({", ".join(parameters)})']


def _wrong_class(name, attributes):
    try:
        names = _part(name).__init__.__code__.co_names
    except (AttributeError, ImportError):
        return [f'{name} is missing']
    return [f'{name} has no attribute {attribute}' for attribute in attributes if attribute not in names]


def _part(name):
    """Return the object with a dotted name: a module, or an attribute of one."""
    path = name.split('.')
    for length in range(len(path), 0, -1):
        try:
            found = importlib.import_module('.'.join(path[:length]))
        except ModuleNotFoundError:
            continue
        for attribute in path[length:]:
            found = getattr(found, attribute)
        return found
    raise ImportError(name)
