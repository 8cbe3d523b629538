"""The answers of rosapi, one function for each service; they ask the master each time.

Threading contract: may be called from any thread.
"""
import collections
import json
import threading
import urllib.parse

import rosgraph
import rospy
import rosservice
import rostopic

from rosapi import srv, typedefs
from rosbridge_core.operations import globs, matches

ACTION_TOPICS = {'cancel', 'feedback', 'goal', 'result', 'status'}
NAMESPACE = '/rosapi/'
_parameters = threading.RLock()  # rospy's client of the parameter server is not made for several threads


class Answers:
    """``call(name, request)`` answers a service; the patterns are texts as ``[/turtle*, /rosout]``: all if empty."""

    def __init__(self, topics_glob='', services_glob='', params_glob=''):
        """Take the patterns of what clients may see and change."""
        self._topic_globs, self._service_globs = globs(topics_glob), globs(services_glob)
        self._param_globs = globs(params_glob)

    def call(self, name, request):
        """Return the response of the service of this name, which is one of SERVICES."""
        return getattr(self, f'_{name}')(request)

    # Topics

    def _topics_and_types(self):
        master = _master()
        types = dict(master.getTopicTypes())
        publishers, subscribers, _ = master.getSystemState()
        names = sorted({name for name, _ in publishers + subscribers})
        return [(name, '' if types.get(name, '*') == '*' else types[name]) for name in names
                if matches(name, self._topic_globs)]

    def _topics(self, _):
        pairs = self._topics_and_types()
        return srv.TopicsResponse([name for name, _ in pairs], [kind for _, kind in pairs])

    def _topics_and_raw_types(self, _):
        pairs = self._topics_and_types()
        return srv.TopicsAndRawTypesResponse([name for name, _ in pairs], [kind for _, kind in pairs],
                                             [typedefs.full_text(kind) for _, kind in pairs])

    def _topics_for_type(self, request):
        return srv.TopicsForTypeResponse([name for name, kind in self._topics_and_types() if kind == request.type])

    def _topic_type(self, request):
        found = matches(request.topic, self._topic_globs) and rostopic.get_topic_type(request.topic)[0]
        return srv.TopicTypeResponse(found or '')

    def _publishers(self, request):
        return srv.PublishersResponse(self._nodes_of(0, request.topic))

    def _subscribers(self, request):
        return srv.SubscribersResponse(self._nodes_of(1, request.topic))

    def _nodes_of(self, part, topic):
        return dict(_master().getSystemState()[part]).get(topic, []) if matches(topic, self._topic_globs) else []

    def _action_servers(self, _):
        parts = collections.defaultdict(set)
        for name, _ in self._topics_and_types():
            namespace, _, last = name.rpartition('/')
            parts[namespace].add(last)
        return srv.GetActionServersResponse(sorted(name for name, found in parts.items()
                                                   if name and found >= ACTION_TOPICS))

    # Services

    def _service_names(self):
        return sorted(name for name, _ in _master().getSystemState()[2] if matches(name, self._service_globs))

    def _services(self, _):
        return srv.ServicesResponse(self._service_names())

    def _services_for_type(self, request):
        return srv.ServicesForTypeResponse([name for name in self._service_names()
                                            if self._type_of(name) == request.type])

    def _type_of(self, service):
        try:
            return (rosservice.get_service_type(service) if matches(service, self._service_globs) else '') or ''
        except (rosservice.ROSServiceException, OSError):
            return ''

    def _service_type(self, request):
        return srv.ServiceTypeResponse(self._type_of(request.service))

    def _service_providers(self, request):
        wanted, services = request.service, _master().getSystemState()[2]
        by_name = wanted.startswith('/')  # as ros-mcp-server asks; the original knows types only
        return srv.ServiceProvidersResponse([node for name, nodes in services for node in nodes
                                             if wanted == (name if by_name else self._type_of(name))])

    def _service_node(self, request):
        return srv.ServiceNodeResponse(rosservice.get_service_node(request.service) or '')

    def _service_host(self, request):
        address = rosservice.get_service_uri(request.service) or ''
        return srv.ServiceHostResponse(urllib.parse.urlsplit(address).hostname or '')

    # Nodes

    def _nodes(self, _):
        return srv.NodesResponse(sorted({node for part in _master().getSystemState() for _, nodes in part
                                         for node in nodes}))

    def _node_details(self, request):
        publishing, subscribing, services = (
            sorted(name for name, nodes in part if request.node in nodes) for part in _master().getSystemState())
        return srv.NodeDetailsResponse(subscribing, publishing, services)

    # Types

    def _message_details(self, request):
        return srv.MessageDetailsResponse(typedefs.of_message(request.type))

    def _service_request_details(self, request):
        return srv.ServiceRequestDetailsResponse(typedefs.of_service(request.type, '_request_class'))

    def _service_response_details(self, request):
        return srv.ServiceResponseDetailsResponse(typedefs.of_service(request.type, '_response_class'))

    # Parameters

    def _allow(self, name):
        if not matches(name, self._param_globs):
            raise rospy.ServiceException(f'the parameter {name} is not among those that clients may use '
                                         f'(~params_glob): {", ".join(self._param_globs)}')

    def _set_param(self, request):
        self._allow(request.name)
        try:
            value = json.loads(request.value)
        except ValueError as error:
            raise rospy.ServiceException(f'the value of {request.name}, {request.value!r}, is not valid JSON: {error}. '
                                         'A text needs quotation marks: "text"') from None
        with _parameters:
            rospy.set_param(request.name, value)
        return srv.SetParamResponse()

    def _get_param(self, request):
        if not matches(request.name, self._param_globs):
            return srv.GetParamResponse('null')
        try:  # rospy would answer "/" with the few parameters below it that it keeps
            value = _master().getParam(rospy.resolve_name(request.name))
            return srv.GetParamResponse(json.dumps(value, default=str))
        except rosgraph.MasterError:  # it is not set
            pass
        try:
            return srv.GetParamResponse(json.dumps(json.loads(request.default)))
        except ValueError:
            return srv.GetParamResponse(json.dumps(request.default or None))

    def _has_param(self, request):
        with _parameters:
            return srv.HasParamResponse(matches(request.name, self._param_globs) and rospy.has_param(request.name))

    def _search_param(self, request):
        with _parameters:
            found = rospy.search_param(request.name) if matches(request.name, self._param_globs) else None
        return srv.SearchParamResponse(found or '')

    def _delete_param(self, request):
        self._allow(request.name)
        with _parameters:
            if rospy.has_param(request.name):
                rospy.delete_param(request.name)
        return srv.DeleteParamResponse()

    def _get_param_names(self, _):
        with _parameters:
            names = rospy.get_param_names()
        return srv.GetParamNamesResponse([name for name in names if matches(name, self._param_globs)])

    def _get_time(self, _):
        return srv.GetTimeResponse(rospy.get_rostime())


def _master():
    return rosgraph.Master(rospy.get_name())


SERVICES = {
    'topics': srv.Topics, 'topics_for_type': srv.TopicsForType, 'topics_and_raw_types': srv.TopicsAndRawTypes,
    'services': srv.Services, 'services_for_type': srv.ServicesForType, 'nodes': srv.Nodes,
    'node_details': srv.NodeDetails, 'action_servers': srv.GetActionServers, 'topic_type': srv.TopicType,
    'service_type': srv.ServiceType, 'publishers': srv.Publishers, 'subscribers': srv.Subscribers,
    'service_providers': srv.ServiceProviders, 'service_node': srv.ServiceNode, 'service_host': srv.ServiceHost,
    'message_details': srv.MessageDetails, 'service_request_details': srv.ServiceRequestDetails,
    'service_response_details': srv.ServiceResponseDetails, 'set_param': srv.SetParam, 'get_param': srv.GetParam,
    'has_param': srv.HasParam, 'search_param': srv.SearchParam, 'delete_param': srv.DeleteParam,
    'get_param_names': srv.GetParamNames, 'get_time': srv.GetTime}  # below /rosapi/
