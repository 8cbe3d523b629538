"""The answers of rosapi: SERVICES has a method for each service; each call asks the master.

The caller imports rosapi's services and messages, so that this package does not depend on rosapi, whose node uses it.

Threading contract: may be called from any thread.
"""
import collections
import json
import threading
import urllib.parse
from types import ModuleType
from typing import Any, Callable, Dict, List, Set, Tuple

import rosgraph
import rospy
import rosservice
import rostopic

from browser_servers import typedefs
from browser_servers.core.operations import globs, matches, ros1_type

ACTION_TOPICS = {'cancel', 'feedback', 'goal', 'result', 'status'}
NAMESPACE = '/rosapi/'
OF_ROS_2 = {'get_param': {'default_value': 'default'}}  # {service: {field in ROS 2: field}}
_parameters = threading.RLock()  # rospy's client of the parameter server is not made for several threads


class Answers:
    """``call(name, request)`` answers a service; ``services`` has the class of each by its name below NAMESPACE."""

    def __init__(self, srv: ModuleType, typedef: Any, topics_glob: str = '', services_glob: str = '',
                 params_glob: str = '') -> None:
        """Take the module ``rosapi.srv``, the class ``rosapi.msg.TypeDef``, and what clients may see and change.

        The patterns are texts such as ``[/turtle*, /rosout]``; an empty one allows everything.
        """
        self._srv, self._typedef = srv, typedef
        self.services = {name: getattr(srv, kind) for name, (kind, _) in SERVICES.items()}
        self._topic_globs, self._service_globs = globs(topics_glob), globs(services_glob)
        self._param_globs = globs(params_glob)

    @staticmethod
    def fields(name: str, arguments: Any) -> Any:
        """Return the arguments of a service, with ROS 1's names of the fields for those of ROS 2."""
        names = OF_ROS_2.get(name, {})
        if not isinstance(arguments, dict) or not names:
            return arguments
        return {names.get(field, field): value for field, value in arguments.items()}

    def call(self, name: str, request: Any) -> Any:
        """Return the response of the service of this name, a key of ``services``."""
        _, answer = SERVICES[name]
        return answer(self, request)

    # Topics

    def _topics_and_types(self) -> List[Tuple[str, str]]:
        master = _master()
        types = dict(master.getTopicTypes())
        publishers, subscribers, _ = master.getSystemState()
        names = sorted({name for name, _ in publishers + subscribers})
        return [(name, '' if types.get(name, '*') == '*' else types[name]) for name in names
                if matches(name, self._topic_globs)]

    def _topics(self, _: Any) -> Any:
        pairs = self._topics_and_types()
        return self._srv.TopicsResponse([name for name, _ in pairs], [kind for _, kind in pairs])

    def _topics_and_raw_types(self, _: Any) -> Any:
        pairs = self._topics_and_types()
        return self._srv.TopicsAndRawTypesResponse([name for name, _ in pairs], [kind for _, kind in pairs],
                                                   [typedefs.full_text(kind) for _, kind in pairs])

    def _topics_for_type(self, request: Any) -> Any:
        return self._srv.TopicsForTypeResponse([name for name, kind in self._topics_and_types()
                                                if kind == ros1_type(request.type)])

    def _topic_type(self, request: Any) -> Any:
        allowed = matches(request.topic, self._topic_globs)
        return self._srv.TopicTypeResponse((rostopic.get_topic_type(request.topic)[0] or '') if allowed else '')

    def _publishers(self, request: Any) -> Any:
        return self._srv.PublishersResponse(self._nodes_of(0, request.topic))

    def _subscribers(self, request: Any) -> Any:
        return self._srv.SubscribersResponse(self._nodes_of(1, request.topic))

    def _nodes_of(self, part: int, topic: str) -> List[str]:
        return dict(_master().getSystemState()[part]).get(topic, []) if matches(topic, self._topic_globs) else []

    def _action_servers(self, _: Any) -> Any:
        parts: Dict[str, Set[str]] = collections.defaultdict(set)
        for name, _ in self._topics_and_types():
            namespace, _, last = name.rpartition('/')
            parts[namespace].add(last)
        return self._srv.GetActionServersResponse(sorted(name for name, topics in parts.items()
                                                         if name and topics >= ACTION_TOPICS))

    # Services

    def _service_names(self) -> List[str]:
        return sorted(name for name, _ in _master().getSystemState()[2] if matches(name, self._service_globs))

    def _services(self, _: Any) -> Any:
        return self._srv.ServicesResponse(self._service_names())

    def _services_for_type(self, request: Any) -> Any:
        return self._srv.ServicesForTypeResponse([name for name in self._service_names()
                                                  if self._type_of(name) == ros1_type(request.type)])

    def _type_of(self, service: str) -> str:
        try:
            return (rosservice.get_service_type(service) or '') if matches(service, self._service_globs) else ''
        except (rosservice.ROSServiceException, OSError):
            return ''

    def _service_type(self, request: Any) -> Any:
        return self._srv.ServiceTypeResponse(self._type_of(request.service))

    def _service_providers(self, request: Any) -> Any:
        by_name = request.service.startswith('/')  # as ros-mcp-server asks; the original knows types only
        return self._srv.ServiceProvidersResponse([
            node for name, nodes in _master().getSystemState()[2] for node in nodes
            if request.service == (name if by_name else self._type_of(name))])

    def _service_node(self, request: Any) -> Any:
        return self._srv.ServiceNodeResponse(rosservice.get_service_node(request.service) or '')

    def _service_host(self, request: Any) -> Any:
        address = rosservice.get_service_uri(request.service) or ''
        return self._srv.ServiceHostResponse(urllib.parse.urlsplit(address).hostname or '')

    # Nodes

    def _nodes(self, _: Any) -> Any:
        return self._srv.NodesResponse(sorted({node for part in _master().getSystemState() for _, nodes in part
                                               for node in nodes}))

    def _node_details(self, request: Any) -> Any:
        publishing, subscribing, services = (
            sorted(name for name, nodes in part if request.node in nodes) for part in _master().getSystemState())
        return self._srv.NodeDetailsResponse(subscribing, publishing, services)

    # Types

    def _typedefs_of_service(self, name: str, part: str) -> List[Any]:
        return self._as_messages(typedefs.of_service(ros1_type(name), part))

    def _as_messages(self, found: List[typedefs.TypeDef]) -> List[Any]:
        return [self._typedef(**vars(typedef)) for typedef in found]

    def _message_details(self, request: Any) -> Any:
        return self._srv.MessageDetailsResponse(self._as_messages(typedefs.of_message(ros1_type(request.type))))

    def _service_request_details(self, request: Any) -> Any:
        return self._srv.ServiceRequestDetailsResponse(self._typedefs_of_service(request.type, '_request_class'))

    def _service_response_details(self, request: Any) -> Any:
        return self._srv.ServiceResponseDetailsResponse(self._typedefs_of_service(request.type, '_response_class'))

    # Parameters

    def _allow(self, name: str) -> None:
        if not matches(name, self._param_globs):
            raise rospy.ServiceException(f'the parameter {name} is not among those that clients may use '
                                         f'(~params_glob): {", ".join(self._param_globs)}')

    def _set_param(self, request: Any) -> Any:
        self._allow(request.name)
        try:
            value = json.loads(request.value)
        except ValueError as error:
            raise rospy.ServiceException(f'the value of {request.name}, {request.value!r}, is not valid JSON: {error}. '
                                         'A text needs quotation marks: "text"') from None
        with _parameters:
            rospy.set_param(request.name, value)
        return self._srv.SetParamResponse()

    def _get_param(self, request: Any) -> Any:
        if not matches(request.name, self._param_globs):
            return self._srv.GetParamResponse('null')
        try:  # rospy would answer "/" with the few parameters below it that it keeps
            value = _master().getParam(rospy.resolve_name(request.name))
            return self._srv.GetParamResponse(json.dumps(value, default=str))
        except rosgraph.MasterError:  # it is not set
            pass
        try:
            return self._srv.GetParamResponse(json.dumps(json.loads(request.default)))
        except ValueError:
            return self._srv.GetParamResponse(json.dumps(request.default or None))

    def _has_param(self, request: Any) -> Any:
        with _parameters:
            return self._srv.HasParamResponse(matches(request.name, self._param_globs)
                                              and rospy.has_param(request.name))

    def _search_param(self, request: Any) -> Any:
        with _parameters:
            name = rospy.search_param(request.name) if matches(request.name, self._param_globs) else None
        return self._srv.SearchParamResponse(name or '')

    def _delete_param(self, request: Any) -> Any:
        self._allow(request.name)
        with _parameters:
            if rospy.has_param(request.name):
                rospy.delete_param(request.name)
        return self._srv.DeleteParamResponse()

    def _get_param_names(self, _: Any) -> Any:
        with _parameters:
            names = rospy.get_param_names()
        return self._srv.GetParamNamesResponse([name for name in names if matches(name, self._param_globs)])

    def _get_time(self, _: Any) -> Any:
        return self._srv.GetTimeResponse(rospy.get_rostime())


# {name below NAMESPACE: (class in rosapi.srv, method that answers)}
SERVICES: Dict[str, Tuple[str, Callable[[Answers, Any], Any]]] = {
    'topics': ('Topics', Answers._topics),
    'topics_and_raw_types': ('TopicsAndRawTypes', Answers._topics_and_raw_types),
    'topics_for_type': ('TopicsForType', Answers._topics_for_type),
    'topic_type': ('TopicType', Answers._topic_type),
    'publishers': ('Publishers', Answers._publishers),
    'subscribers': ('Subscribers', Answers._subscribers),
    'action_servers': ('GetActionServers', Answers._action_servers),
    'services': ('Services', Answers._services),
    'services_for_type': ('ServicesForType', Answers._services_for_type),
    'service_type': ('ServiceType', Answers._service_type),
    'service_providers': ('ServiceProviders', Answers._service_providers),
    'service_node': ('ServiceNode', Answers._service_node),
    'service_host': ('ServiceHost', Answers._service_host),
    'nodes': ('Nodes', Answers._nodes),
    'node_details': ('NodeDetails', Answers._node_details),
    'message_details': ('MessageDetails', Answers._message_details),
    'service_request_details': ('ServiceRequestDetails', Answers._service_request_details),
    'service_response_details': ('ServiceResponseDetails', Answers._service_response_details),
    'set_param': ('SetParam', Answers._set_param),
    'get_param': ('GetParam', Answers._get_param),
    'has_param': ('HasParam', Answers._has_param),
    'search_param': ('SearchParam', Answers._search_param),
    'delete_param': ('DeleteParam', Answers._delete_param),
    'get_param_names': ('GetParamNames', Answers._get_param_names),
    'get_time': ('GetTime', Answers._get_time),
}


def _master() -> Any:
    return rosgraph.Master(rospy.get_name())
