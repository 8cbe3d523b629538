"""The answers of rosapi, one method for each service; each call asks the master.

The caller imports rosapi's services and messages, so that this package does not depend on rosapi, whose node uses it.

Threading contract: may be called from any thread.
"""
import collections
import json
import re
import threading
import urllib.parse

import rosgraph
import rospy
import rosservice
import rostopic

from browser_servers import typedefs
from browser_servers.core.operations import globs, matches, ros1_type

ACTION_TOPICS = {'cancel', 'feedback', 'goal', 'result', 'status'}
NAMESPACE = '/rosapi/'
NAMES = {'get_action_servers': 'action_servers'}  # of services that differ from those of their classes
OF_ROS_2 = {'get_param': {'default_value': 'default'}}  # {service: {field in ROS 2: field}}
_parameters = threading.RLock()  # rospy's client of the parameter server is not made for several threads


class Answers:
    """``call(name, request)`` answers a service; ``services`` has the class of each by its name below NAMESPACE."""

    def __init__(self, srv, typedef, topics_glob='', services_glob='', params_glob=''):
        """Take the module ``rosapi.srv``, the class ``rosapi.msg.TypeDef``, and what clients may see and change.

        The patterns are texts such as ``[/turtle*, /rosout]``; an empty one allows everything.
        """
        self._srv, self._typedef = srv, typedef
        named = {re.sub('(?<=.)(?=[A-Z])', '_', name).lower(): cls for name, cls in vars(srv).items()}
        self.services = {NAMES.get(name, name): cls for name, cls in named.items()
                         if hasattr(self, f'_{NAMES.get(name, name)}')}
        self._topic_globs, self._service_globs = globs(topics_glob), globs(services_glob)
        self._param_globs = globs(params_glob)

    @staticmethod
    def fields(name, arguments):
        """Return the arguments of a service, with ROS 1's names of the fields for those of ROS 2."""
        names = OF_ROS_2.get(name, {})
        if not isinstance(arguments, dict) or not names:
            return arguments
        return {names.get(field, field): value for field, value in arguments.items()}

    def call(self, name, request):
        """Return the response of the service of this name, a key of ``services``."""
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
        return self._srv.TopicsResponse([name for name, _ in pairs], [kind for _, kind in pairs])

    def _topics_and_raw_types(self, _):
        pairs = self._topics_and_types()
        return self._srv.TopicsAndRawTypesResponse([name for name, _ in pairs], [kind for _, kind in pairs],
                                             [typedefs.full_text(kind) for _, kind in pairs])

    def _topics_for_type(self, request):
        return self._srv.TopicsForTypeResponse([name for name, kind in self._topics_and_types()
                                                if kind == ros1_type(request.type)])

    def _topic_type(self, request):
        found = matches(request.topic, self._topic_globs) and rostopic.get_topic_type(request.topic)[0]
        return self._srv.TopicTypeResponse(found or '')

    def _publishers(self, request):
        return self._srv.PublishersResponse(self._nodes_of(0, request.topic))

    def _subscribers(self, request):
        return self._srv.SubscribersResponse(self._nodes_of(1, request.topic))

    def _nodes_of(self, part, topic):
        return dict(_master().getSystemState()[part]).get(topic, []) if matches(topic, self._topic_globs) else []

    def _action_servers(self, _):
        parts = collections.defaultdict(set)
        for name, _ in self._topics_and_types():
            namespace, _, last = name.rpartition('/')
            parts[namespace].add(last)
        return self._srv.GetActionServersResponse(sorted(name for name, found in parts.items()
                                                   if name and found >= ACTION_TOPICS))

    # Services

    def _service_names(self):
        return sorted(name for name, _ in _master().getSystemState()[2] if matches(name, self._service_globs))

    def _services(self, _):
        return self._srv.ServicesResponse(self._service_names())

    def _services_for_type(self, request):
        return self._srv.ServicesForTypeResponse([name for name in self._service_names()
                                                  if self._type_of(name) == ros1_type(request.type)])

    def _type_of(self, service):
        try:
            return (rosservice.get_service_type(service) if matches(service, self._service_globs) else '') or ''
        except (rosservice.ROSServiceException, OSError):
            return ''

    def _service_type(self, request):
        return self._srv.ServiceTypeResponse(self._type_of(request.service))

    def _service_providers(self, request):
        wanted, services = request.service, _master().getSystemState()[2]
        by_name = wanted.startswith('/')  # as ros-mcp-server asks; the original knows types only
        return self._srv.ServiceProvidersResponse([node for name, nodes in services for node in nodes
                                             if wanted == (name if by_name else self._type_of(name))])

    def _service_node(self, request):
        return self._srv.ServiceNodeResponse(rosservice.get_service_node(request.service) or '')

    def _service_host(self, request):
        address = rosservice.get_service_uri(request.service) or ''
        return self._srv.ServiceHostResponse(urllib.parse.urlsplit(address).hostname or '')

    # Nodes

    def _nodes(self, _):
        return self._srv.NodesResponse(sorted({node for part in _master().getSystemState() for _, nodes in part
                                         for node in nodes}))

    def _node_details(self, request):
        publishing, subscribing, services = (
            sorted(name for name, nodes in part if request.node in nodes) for part in _master().getSystemState())
        return self._srv.NodeDetailsResponse(subscribing, publishing, services)

    # Types

    def _typedefs_of_service(self, name, part):
        return self._as_messages(typedefs.of_service(ros1_type(name), part))

    def _as_messages(self, found):
        return [self._typedef(**vars(one)) for one in found]

    def _message_details(self, request):
        return self._srv.MessageDetailsResponse(self._as_messages(typedefs.of_message(ros1_type(request.type))))

    def _service_request_details(self, request):
        return self._srv.ServiceRequestDetailsResponse(self._typedefs_of_service(request.type, '_request_class'))

    def _service_response_details(self, request):
        return self._srv.ServiceResponseDetailsResponse(self._typedefs_of_service(request.type, '_response_class'))

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
        return self._srv.SetParamResponse()

    def _get_param(self, request):
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

    def _has_param(self, request):
        with _parameters:
            return self._srv.HasParamResponse(matches(request.name, self._param_globs)
                                              and rospy.has_param(request.name))

    def _search_param(self, request):
        with _parameters:
            found = rospy.search_param(request.name) if matches(request.name, self._param_globs) else None
        return self._srv.SearchParamResponse(found or '')

    def _delete_param(self, request):
        self._allow(request.name)
        with _parameters:
            if rospy.has_param(request.name):
                rospy.delete_param(request.name)
        return self._srv.DeleteParamResponse()

    def _get_param_names(self, _):
        with _parameters:
            names = rospy.get_param_names()
        return self._srv.GetParamNamesResponse([name for name in names if matches(name, self._param_globs)])

    def _get_time(self, _):
        return self._srv.GetTimeResponse(rospy.get_rostime())


def _master():
    return rosgraph.Master(rospy.get_name())
