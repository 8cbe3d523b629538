"""The only package that touches private parts of rospy; checked against rospy 1.15, 1.16, 1.17.

All other modules use only the documented API of rospy. ``misfits()`` lists what differs in another version of rospy,
and a unit test fails with that list. The grader's student_path/sitecustomize.py replaces
``rospy.impl.simtime.init_simtime`` in a student's program, where this package is not available; the list covers what
it uses, too.

Each guard names the fault that it is for, and its test.
"""
from rospy_support.rospy_internals.compatibility import CHECKED, misfits, version
from rospy_support.rospy_internals.process import (
    LOG_PARAMETER,
    end_registering,
    follow_time,
    is_wall_time,
    limit_calls_of_master,
    log_without_asking,
    logging_configured_by,
    set_time,
    shut_down_by,
    shutting_down,
    wait_for_shutdown,
)
from rospy_support.rospy_internals.registration import (
    Call,
    collected_registrations,
    collected_unregistrations,
    command_line_parameters,
    poll_for_registration,
    registered,
)
from rospy_support.rospy_internals.servers import (
    attribute_connections,
    limit_messages,
    replace_slave_server,
    replace_tcpros_server,
)
from rospy_support.rospy_internals.services import (
    QueuedService,
    ServiceCall,
    find_service,
    offered_services,
    respond,
    service_error,
    service_header,
    transport_of,
)
from rospy_support.rospy_internals.topics import (
    caller,
    connection_header,
    connections,
    count_publication,
    frame,
    holder,
    limit_publishers,
    new_publishers,
    publications,
    publish_without_threads,
    published_messages,
    subscriptions,
    take_over,
    tell_connections_apart,
    to_message,
    unconnected_publications,
    unconnected_subscriptions,
)

__all__ = [
    'CHECKED', 'Call', 'LOG_PARAMETER', 'QueuedService', 'ServiceCall', 'attribute_connections', 'caller',
    'collected_registrations', 'collected_unregistrations', 'command_line_parameters', 'connection_header',
    'connections', 'count_publication', 'end_registering', 'find_service', 'follow_time', 'frame', 'holder',
    'is_wall_time', 'limit_calls_of_master', 'limit_messages', 'limit_publishers', 'log_without_asking',
    'logging_configured_by', 'misfits', 'new_publishers', 'offered_services', 'poll_for_registration', 'publications',
    'publish_without_threads', 'published_messages', 'registered', 'replace_slave_server', 'replace_tcpros_server',
    'respond', 'service_error', 'service_header', 'set_time', 'shut_down_by', 'shutting_down', 'subscriptions',
    'take_over', 'tell_connections_apart', 'to_message', 'transport_of', 'unconnected_publications',
    'unconnected_subscriptions', 'version', 'wait_for_shutdown']
