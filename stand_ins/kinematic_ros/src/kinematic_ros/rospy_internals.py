"""The only module that touches private parts of rospy; checked against rospy 1.15, 1.16, 1.17.

Everything else uses rospy as it is documented. ``misfits()`` says what another rospy has changed; the unit test of
this module fails with that text. student_path/sitecustomize.py, which runs in a student's program without this
package, changes ``rospy.impl.simtime.init_simtime``; what it uses is checked here too.
"""
import contextlib
import functools
import importlib
import importlib.metadata
import inspect
import io
import re
import sys
import time
import xmlrpc.client

import rosgraph.roslogging
import rospy
import rospy.client
import rospy.core
import rospy.impl.masterslave
import rospy.impl.paramserver
import rospy.impl.simtime
import rospy.msg
import rospy.rostime
from rospy.impl.registration import RegManager, get_registration_listeners, get_service_manager, get_topic_manager

CHECKED = '1.15', '1.16', '1.17'  # versions of rospy
LOG_PARAMETER = '/rosout_disable_topics_generation'  # leaves out a field of lines on /rosout

FUNCTIONS = {  # what is called or replaced: names of its parameters
    'rosgraph.roslogging.configure_logging': ('logname', 'level', 'filename', 'env'),
    'rospy.client.load_command_line_node_params': ('argv',),
    'rospy.core.is_shutdown': (),
    'rospy.core.is_shutdown_requested': (),
    'rospy.impl.masterslave.ROSHandler.shutdown': ('args', 'kwds'),  # as its decorator leaves it
    'rospy.impl.paramserver.get_param_server_cache': (),
    'rospy.impl.paramserver.ParamServerCache.set': ('self', 'key', 'value'),
    'rospy.impl.registration.get_registration_listeners': (),
    'rospy.impl.registration.RegManager.publisher_update': ('self', 'resolved_name', 'uris'),
    'rospy.msg.args_kwds_to_message': ('data_class', 'args', 'kwds'),
    'rospy.msg.serialize_message': ('b', 'seq', 'msg'),
    'rospy.rostime._set_rostime': ('t',),
    'rospy.rostime.get_rostime_cond': (),
    'rospy.rostime.is_wallclock': (),
    'rospy.impl.simtime.init_simtime': (),
    'rospy.impl.registration.get_topic_manager': (),
    'rospy.impl.registration.get_service_manager': (),
    'rospy.topics._TopicManager.get_publications': ('self',),
    'rospy.topics._TopicManager.get_subscriptions': ('self',),
    'rospy.topics._TopicManager.get_publisher_impl': ('self', 'resolved_name'),
    'rospy.topics._TopicManager.get_subscriber_impl': ('self', 'resolved_name'),
    'rospy.topics._TopicImpl.has_connections': ('self',),
    'rospy.topics._PublisherImpl.set_queue_size': ('self', 'queue_size'),
    'rospy.service.ServiceManager.get_services': ('self',),
    'rospy.impl.tcpros_base.TCPROSTransport.close': ('self',),
}
ATTRIBUTES = {  # what objects of a class have: names that its constructor sets
    'rospy.topics.Topic': ('impl',),
    'rospy.topics._TopicImpl': ('connections',),
    'rospy.impl.tcpros_base.TCPROSTransport': ('socket', 'endpoint_id'),
}
OBJECTS = ('rospy.core._shutdown_lock.acquire',)  # what is used besides


def connections(publisher):
    """Return the connections of a rospy.Publisher; none once it is unregistered. The sequence is not to be changed.

    A connection has ``endpoint_id``, the name of the node that subscribes, ``socket``, which is None once rospy has
    closed it, and ``close()``.
    """
    impl = publisher.impl  # unregister, in another thread, sets it to None
    return impl.connections if impl else ()


def publish_without_threads(publisher):
    """Let rospy make no thread for each connection of a Publisher; who publishes then writes to them itself."""
    publisher.impl.set_queue_size(None)


def caller(message):
    """Return the name of the node that sent a message or a service request; '' where rospy does not know it."""
    return (getattr(message, '_connection_header', None) or {}).get('callerid', '')


def to_message(data_class, args, kwds):
    """Return the message that a call publish(*args, **kwds) means: a message itself, or its fields."""
    return rospy.msg.args_kwds_to_message(data_class, args, kwds)


def frame(message, seq=0):
    """Return a message, with header.seq ``seq``, as the bytes of a TCPROS connection: its length, then its fields."""
    buffer = io.BytesIO()
    rospy.msg.serialize_message(buffer, seq, message)
    return buffer.getvalue()


def set_time(now):
    """Set what rospy.Time.now() is in this process, as a message on /clock does; ``now`` is a rospy.Time."""
    rospy.rostime._set_rostime(now)


def follow_time():
    """Let time come from /clock where /use_sim_time is true, else from the wall clock: what init_node does unless it
    is told ``disable_rostime``. Return whether that worked."""
    return rospy.impl.simtime.init_simtime()


def is_wall_time():
    """Return whether rospy's time is the wall clock's."""
    return rospy.rostime.is_wallclock()


def steady_time():
    """Return a time [s] to measure durations with: ROS time where it is simulated, else that of a clock nobody sets."""
    return time.monotonic() if is_wall_time() else rospy.get_time()


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
    """Return the names of the topics that this node publishes and that no node is connected to."""
    manager = get_topic_manager()
    return _unconnected(manager.get_publications(), manager.get_publisher_impl)


def unconnected_subscriptions():
    """Return the names of the topics that this node subscribes to and is connected to no publisher of."""
    manager = get_topic_manager()
    return _unconnected(manager.get_subscriptions(), manager.get_subscriber_impl)


def _unconnected(topics, implementation):
    pairs = [(name, implementation(name)) for name, _ in topics]
    return {name for name, topic in pairs if topic is not None and not topic.has_connections()}


def command_line_parameters(argv=None):
    """Return {absolute name: value} of the private parameters that this process was given as _name:=value."""
    given = rospy.client.load_command_line_node_params(sys.argv if argv is None else argv)
    return {rospy.resolve_name(f'~{name}'): value for name, value in given.items()}


def log_without_asking():
    """Let no line that is logged ask the master; call it once rospy is initialised.

    rospy asks at each line whether LOG_PARAMETER is set, until it is, and subscribes to it: that takes time, a master
    that stands stops the node with it, one that was started anew believes that it knows the node, and one that the node
    has left still does: it would tell whoever has the node's port then to shut down. Here it is asked once.
    """
    try:
        value = rospy.get_param(LOG_PARAMETER, False)
    except (OSError, xmlrpc.client.Error):
        value = False
    rospy.impl.paramserver.get_param_server_cache().set(LOG_PARAMETER, value)


def new_publishers(topic, uris):
    """Tell rospy which nodes, given by their URIs, publish a topic that this node subscribes to; it connects."""
    for listener in get_registration_listeners().listeners:
        if isinstance(listener, RegManager):
            listener.publisher_update(topic, uris)


def shutting_down():
    """Return whether the shutdown has begun; rospy.is_shutdown() says so only after hooks were called."""
    return rospy.core.is_shutdown_requested() or rospy.core.is_shutdown()


def wait_for_shutdown():
    """Wait until rospy.signal_shutdown, if another thread is in it, has called all hooks."""
    with rospy.core._shutdown_lock:
        pass


def shut_down_by(function):
    """Let ``function(reason)`` shut down when another node (the master, rosnode kill) asks for it, which it answers.

    A master that was not told of a node's end may ask whoever has that node's port now; that is ignored.
    """
    def shutdown(self, caller_id, msg=''):
        print(f'shutdown request: {msg}')
        meant = re.match(r'\[(/\S*)\] Reason: ', str(msg))  # the master's way to say who
        if meant and meant.group(1) != self.name:
            rospy.logwarn('Ignored a request to shut down that was meant for %s', meant.group(1))
            return 0, f'this is {self.name}', 0
        function(f'external shutdown request from [{caller_id}]: [{msg}]')
        return 1, 'shutdown', 0
    rospy.impl.masterslave.ROSHandler.shutdown = shutdown


@contextlib.contextmanager
def logging_configured_by(function):
    """In this context let rospy.init_node call function(original, *arguments, **options) to configure logging."""
    original = rosgraph.roslogging.configure_logging
    rosgraph.roslogging.configure_logging = functools.partial(function, original)
    try:
        yield
    finally:
        rosgraph.roslogging.configure_logging = original


def version():
    """Return the version of rospy as text; '?' where it was installed without saying."""
    try:
        return importlib.metadata.version('rospy')
    except importlib.metadata.PackageNotFoundError:
        return '?'


def misfits():
    """Return a line for each private part of rospy that is not as this module needs it; none where all fits."""
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
    """Return what a dotted name means: modules as far as there are any, then attributes."""
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
