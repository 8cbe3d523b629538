"""Keep a node registered with the ROS master, even after the master restarts; delete its parameters when it ends.

rospy registers a topic or service once. After a restart of roscore, a running node stays invisible forever. This module
notices the restart and registers everything again: the parameters of the command line, topics, services.

rospy leaves the parameters of a command line (_name:=value) on the master, where they change what the same command
does the next time. This module deletes them when the node ends, unless another program has changed them.

A master knows the node if it knows ``~get_loggers``, a service that every node has and that only the node registers.
(The node's name is no proof: a master also learns it when the node asks for a parameter.)
"""
import contextlib
import http.client
import threading
import xmlrpc.client
from types import MappingProxyType
from typing import Any, Callable, Dict, Iterable, List, Mapping

import rosgraph
import rospy

from rospy_support import rospy_internals
from rospy_support.master import TIMEOUT, Master, NoMaster
from rospy_support.rospy_internals import Call

PERIOD = 1.0  # [s] between two checks of the master
SIGN = '~get_loggers'  # a node is registered if the master knows this service
UNREGISTER_TIMEOUT = 2.0  # [s] for an answer of the master to a node that ends
REST_TIMEOUT = 1.0  # [s] the same for a node that has shut down
TROUBLES = NoMaster, OSError, rosgraph.MasterException, xmlrpc.client.Error, http.client.HTTPException

_hooks: List[Callable[[], Any]] = []  # called after each repeated registration
_deleted_at_end: Dict[str, Any] = {}  # {absolute name: value}


def on_return(function: Callable[[], Any]) -> None:
    """Call ``function()``, in another thread, each time the node has been registered again.

    If it raises one of TROUBLES, the registration is repeated.
    """
    _hooks.append(function)


def keep_parameter(name: str, value: Any) -> None:
    """Set a parameter, now and on each master that the node is registered with again."""
    rospy.set_param(name, value)
    on_return(lambda: rospy.set_param(name, value))


def delete_at_end(parameters: Mapping[str, Any]) -> None:
    """Delete the parameters {absolute name: value} when the node ends, unless they have another value by then."""
    _deleted_at_end.update(parameters)


def keep_registered(parameters: Mapping[str, Any] = MappingProxyType({}), period: float = PERIOD) -> threading.Thread:
    """Start a thread that watches the master, and return it.

    ``parameters`` {absolute name: value} are set again on a restarted master, and deleted at the end.
    """
    watch = _Watch(dict(parameters))
    rospy.on_shutdown(watch.end)
    thread = threading.Thread(target=watch.run, args=(period,), name='keep_registered', daemon=True)
    thread.start()
    return thread


def unregister_rest() -> None:
    """Unregister the names that the master still lists for this node; call it last.

    A node that is stopped while it starts keeps registering until it notices, but rospy unregisters only once.
    """
    with contextlib.suppress(*TROUBLES):
        name, uri, master = rospy.get_name(), rospy.get_node_uri(), Master(REST_TIMEOUT)
        (_, _, known), = master.request([('lookupNode', name)])
        if not uri or known != uri:  # nothing is left, or a newer node has this name
            return
        (_, _, state), = master.request([('getSystemState',)])
        published, subscribed, served = ([each for each, nodes in kind if name in nodes] for kind in state)
        addresses = master.request([('lookupService', service) for service in served])
        master.request([
            *(('unregisterPublisher', topic, uri) for topic in published),
            *(('unregisterSubscriber', topic, uri) for topic in subscribed),
            *(('unregisterService', service, address) for service, (_, _, address) in zip(served, addresses))])


def values_of(calls: Iterable[Call]) -> List[Any]:
    """Make calls (method, argument, ...) to the master in as few requests as possible; return the list of their values.

    Raise one of TROUBLES if the master does not answer or refuses a call.
    """
    calls = list(calls)
    answers = Master(TIMEOUT).request(calls)
    for (method, *_), (code, text, _) in zip(calls, answers):
        if code != 1:
            raise rosgraph.MasterError(f'{method}: {text}')
    return [value for _, _, value in answers]


class _Watch:
    """Watches the master, and registers the node again if necessary."""

    def __init__(self, parameters: Dict[str, Any]) -> None:
        self._parameters = parameters
        self._ended = threading.Event()
        self._registering = threading.Lock()
        self._lost = False  # the node must be registered again
        self._away = False  # the missing master was reported

    def run(self, period: float) -> None:
        """Check every ``period`` [s] until the node ends."""
        while not self._ended.wait(period):
            try:
                self._check()
            except Exception as error:  # one of TROUBLES, or an answer of another program, which is not XML
                if not self._away and not self._ended.is_set():
                    self._away = True
                    rospy.logwarn('The ROS master does not answer: %s. Continuing without it; the node will register '
                                  'again when it returns (roscore).', error)

    def end(self) -> None:
        """Stop watching; the slow part runs after all other hooks of the shutdown, because those stop vehicles."""
        self._ended.set()
        rospy.on_shutdown(self._finish)

    def _finish(self) -> None:
        """Wait for a registration in progress, then delete the parameters."""
        if self._registering.acquire(timeout=TIMEOUT):
            self._registering.release()
            with contextlib.suppress(*TROUBLES):
                _delete({**self._parameters, **_deleted_at_end})

    def _check(self) -> None:
        self._lost = self._lost or not _known()
        if self._lost:
            with self._registering:
                if self._ended.is_set() or rospy_internals.shutting_down():
                    return
                _register_all(self._parameters)
            for hook in list(_hooks):
                hook()
            self._lost = False
            rospy.logwarn('The ROS master was restarted: registered again.')
        elif self._away:
            rospy.logwarn('The ROS master answers again.')
        self._away = False


def _known() -> bool:
    """Return whether the master knows this node; end the node if another one has taken its name."""
    sign = rospy.resolve_name(SIGN)
    (code, _, uri), = Master(TIMEOUT).request([('lookupService', sign)])
    if code == 1 and uri != dict(rospy_internals.offered_services()).get(sign, uri):
        rospy.logfatal('Another node with the name %s is registered with the ROS master: this one ends, as a ROS node '
                       'does when a newer one takes its name.', rospy.get_name())
        rospy.signal_shutdown('another node has taken its name')
    return code == 1


def _delete(parameters: Mapping[str, Any]) -> None:
    """Delete the parameters {absolute name: value} that still have this value, unless a newer node has this name."""
    if not parameters:
        return
    sign, master = rospy.resolve_name(SIGN), Master(UNREGISTER_TIMEOUT)
    (code, _, uri), (_, _, node), *answers = master.request([
        ('lookupService', sign), ('lookupNode', rospy.get_name()), *(('getParam', name) for name in parameters)])
    if code == 1 and uri == dict(rospy_internals.offered_services()).get(sign) and node == rospy.get_node_uri():
        master.request([('deleteParam', name) for (name, value), (there, _, now) in zip(parameters.items(), answers)
                        if there == 1 and now == value])


def _register_all(parameters: Mapping[str, Any]) -> None:
    there = values_of(('hasParam', name) for name in parameters)
    values_of(('setParam', name, value) for (name, value), known in zip(parameters.items(), there) if not known)
    uri, sign = rospy.get_node_uri(), rospy.resolve_name(SIGN)
    subscribed = rospy_internals.subscriptions()
    services = sorted(rospy_internals.offered_services(), key=lambda service: service[0] == sign)  # the sign comes last
    values = values_of([
        *(('registerSubscriber', name, data_type, uri) for name, data_type in subscribed),
        *(('registerPublisher', name, data_type, uri) for name, data_type in rospy_internals.publications()),
        *(('registerService', name, service_uri, uri) for name, service_uri in services)])
    for (name, _), publishers in zip(subscribed, values):
        rospy_internals.new_publishers(name, publishers)
