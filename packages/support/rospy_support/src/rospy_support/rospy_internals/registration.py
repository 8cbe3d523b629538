"""Registration with the master: many topics and services in one request, and the parameters of the command line."""
import contextlib
import select
import sys
import threading
import time
import types
from typing import Any, Dict, Iterator, List, Optional, Sequence, Set, Tuple

import rospy
import rospy.client
import rospy.impl.init
from rospy.impl.registration import Registration, get_registration_listeners, get_topic_manager
from rospy.impl.statistics import SubscriberStatisticsLogger

from rospy_support.rospy_internals.topics import new_publishers

STATISTICS_PARAMETER = '/enable_statistics'  # true: subscribers publish statistics of their messages
REGISTRATION_POLL = 0.005  # [s]; a master answers in 3 ms
_KINDS = {Registration.PUB: 'Publisher', Registration.SUB: 'Subscriber', Registration.SRV: 'Service'}
Call = Tuple[Any, ...]  # a method of the master's XML-RPC interface, and its arguments after the caller's name
_collecting = threading.local()  # calls: the list that this thread collects, else None or missing


def poll_for_registration() -> None:
    """Let init_node poll for the answer of the master every REGISTRATION_POLL; rospy polls every 0.1 s."""
    rospy.impl.init.time = types.SimpleNamespace(sleep=lambda seconds: time.sleep(min(seconds, REGISTRATION_POLL)))


def command_line_parameters(argv: Optional[Sequence[str]] = None) -> Dict[str, Any]:
    """Return {absolute name: value} of the private parameters given as _name:=value on the command line."""
    given = rospy.client.load_command_line_node_params(sys.argv if argv is None else argv)
    return {rospy.resolve_name(f'~{name}'): value for name, value in given.items()}


class _ConnectionPoll:
    """Replaces rospy's poller of broken connections.

    The fault: rospy takes a file descriptor for each topic, 3,020 for a thousand turtles. The topic's lock of its
    connections is held meanwhile, see tell_connections_apart: two threads cannot use select.poll at the same time.
    """

    def __init__(self) -> None:
        self._poll = select.poll()
        self._files: Set[int] = set()

    def add_fd(self, file: int) -> None:
        """Watch a connection."""
        self._poll.register(file, 0)  # POLLHUP and POLLERR are always reported
        self._files.add(file)

    def remove_fd(self, file: int) -> None:
        """Stop watching a connection; raise KeyError if it was not watched."""
        self._poll.unregister(file)
        self._files.remove(file)

    def error_iter(self) -> List[int]:
        """Return the broken connections."""
        return [file for file, event in self._poll.poll(0) if event] if self._files else []



@contextlib.contextmanager
def collected_registrations() -> Iterator[List[Call]]:
    """Collect the registrations that this thread makes as a list of calls; none is sent to the master.

    The fault: with one request for each, to spawn a turtle takes 55 ms among a thousand.

    A call is a tuple: a method of the master's XML-RPC interface, then its arguments after the caller's name.
    """
    _divert(get_registration_listeners())
    calls: List[Call] = []
    _collecting.calls = calls
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


def registered(calls: Sequence[Call], values: Sequence[Any]) -> None:
    """Process the master's answers to the calls of collected_registrations, as rospy does; None: a refused call."""
    for (method, name, *_), value in zip(calls, values):
        if method == 'registerSubscriber':
            if value:
                new_publishers(name, value)
            if values[-1]:
                topic = get_topic_manager().subs[name]
                topic.statistics_logger = SubscriberStatisticsLogger(topic)


@contextlib.contextmanager
def collected_unregistrations() -> Iterator[List[Call]]:
    """Collect the names that this thread unregisters, as collected_registrations does.

    The fault: rospy goes through all topics for each one that it removes; a reset of 1,000 turtles took 17 s.
    """
    _divert(get_registration_listeners())
    manager = get_topic_manager()
    calls: List[Call] = []
    _collecting.calls = calls
    with manager.lock:
        manager._recalculate_topics = lambda: None  # rospy goes through all topics each time it removes one
        try:
            yield calls
        finally:
            _collecting.calls = None
            del manager._recalculate_topics
            manager._recalculate_topics()


def _divert(listeners: Any) -> None:
    """Make rospy collect its calls of the master in a thread that collects, and send them in all others."""
    if 'notify_added' in vars(listeners):
        return
    tell_added, tell_removed = listeners.notify_added, listeners.notify_removed
    statistics_wanted = SubscriberStatisticsLogger.is_enabled

    def added(name: str, type_or_uri: str, kind: str) -> None:
        if getattr(_collecting, 'calls', None) is None:
            tell_added(name, type_or_uri, kind)
        else:
            _collecting.calls.append((f'register{_KINDS[kind]}', name, type_or_uri, rospy.get_node_uri()))

    def removed(name: str, type_or_uri: str, kind: str) -> None:
        if getattr(_collecting, 'calls', None) is None:
            tell_removed(name, type_or_uri, kind)
        else:
            uri = type_or_uri if kind == Registration.SRV else rospy.get_node_uri()
            _collecting.calls.append((f'unregister{_KINDS[kind]}', name, uri))
    listeners.notify_added, listeners.notify_removed = added, removed
    SubscriberStatisticsLogger.is_enabled = lambda: getattr(_collecting, 'calls', None) is None and statistics_wanted()
