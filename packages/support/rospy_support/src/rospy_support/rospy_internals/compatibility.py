"""The table of all private parts of rospy that rospy_internals uses, and a check of the installed rospy against it."""
import importlib
import importlib.metadata
import inspect
from typing import Any, Iterable, List, Tuple

CHECKED = '1.15', '1.16', '1.17'  # versions of rospy
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
    'rospy.impl.tcpros_base.TCPServer.__init__': ('self', 'inbound_handler', 'port'),
    'rospy.impl.tcpros_base.TCPServer.start': ('self',),
    'rospy.impl.tcpros_base.TCPServer.shutdown': ('self',),
    'rospy.impl.tcpros_base.TCPROSServer._tcp_server_callback': ('self', 'sock', 'client_addr'),
    'rospy.impl.tcpros_base.TCPROSTransport.__init__': ('self', 'protocol', 'name', 'header'),
    'rospy.impl.tcpros_base.TCPROSTransport.set_socket': ('self', 'sock', 'endpoint_id'),
    'rospy.impl.tcpros_base.TCPROSTransport.connect': ('self', 'dest_addr', 'dest_port', 'endpoint_id', 'timeout'),
    'rospy.impl.tcpros_base.TCPROSTransport.close': ('self',),
    'rospy.impl.tcpros_base.TCPROSTransport.receive_once': ('self',),
    'rospy.impl.tcpros_base.TCPROSTransport.receive_loop': ('self', 'msgs_callback'),
    'rospy.impl.tcpros_base.TCPROSTransportProtocol.read_messages': ('self', 'b', 'msg_queue', 'sock'),
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


def version() -> str:
    """Return the version of rospy; '?' if its installation does not tell."""
    try:
        return importlib.metadata.version('rospy')
    except importlib.metadata.PackageNotFoundError:
        return '?'


def misfits() -> List[str]:
    """Return one line for each private part of rospy that this module needs and that differs; [] if none does."""
    return ([line for name, parameters in FUNCTIONS.items() for line in _wrong_function(name, parameters)]
            + [line for name, attributes in ATTRIBUTES.items() for line in _wrong_class(name, attributes)]
            + [f'{name} is missing' for name in OBJECTS if not _there(name)])


def _there(name: str) -> bool:
    try:
        _part(name)
    except (AttributeError, ImportError):
        return False
    return True


def _wrong_function(name: str, parameters: Tuple[str, ...]) -> List[str]:
    try:
        found = tuple(inspect.signature(_part(name)).parameters)
    except (AttributeError, ImportError, TypeError, ValueError):
        return [f'{name} is missing']
    return [] if found == parameters else [f'{name} takes ({", ".join(found)}), not ({", ".join(parameters)})']


def _wrong_class(name: str, attributes: Iterable[str]) -> List[str]:
    try:
        names = _part(name).__init__.__code__.co_names
    except (AttributeError, ImportError):
        return [f'{name} is missing']
    return [f'{name} has no attribute {attribute}' for attribute in attributes if attribute not in names]


def _part(name: str) -> Any:
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
