"""The process of a node: its log, its clock, and its shutdown."""
import contextlib
import functools
import re
import xmlrpc.client
from typing import Any, Callable, Iterator, Tuple

import rosgraph.roslogging
import rospy
import rospy.core
import rospy.impl.masterslave
import rospy.impl.paramserver
import rospy.impl.simtime
import rospy.rostime
from rospy.impl.registration import get_service_manager, get_topic_manager

from rospy_support.limited_transport import LimitedTransport

LOG_PARAMETER = '/rosout_disable_topics_generation'  # true: messages on /rosout do not list the node's topics


def log_without_asking() -> None:
    """Keep log calls from asking the master for LOG_PARAMETER; ask for it once. Call it after init_node.

    The fault: while LOG_PARAMETER is not set, rospy asks for it at each log line and subscribes to it. That takes time;
    a master that hangs blocks the node; a restarted master seems to know the node, which never registers again; and a
    master that lists the node after its end sends a shutdown request to the next owner of its port.
    """
    try:
        value = rospy.get_param(LOG_PARAMETER, False)
    except (OSError, xmlrpc.client.Error):
        value = False
    rospy.impl.paramserver.get_param_server_cache().set(LOG_PARAMETER, value)


@contextlib.contextmanager
def logging_configured_by(function: Callable[..., Any]) -> Iterator[None]:
    """In this context, rospy.init_node configures logging by ``function(original, *arguments, **options)``."""
    original = rosgraph.roslogging.configure_logging
    rosgraph.roslogging.configure_logging = functools.partial(function, original)
    try:
        yield
    finally:
        rosgraph.roslogging.configure_logging = original


def set_time(now: rospy.Time) -> None:
    """Set the ROS time of this process, as a message on /clock does; ``now`` is a rospy.Time."""
    rospy.rostime._set_rostime(now)


def follow_time() -> bool:
    """Take the time from /clock if /use_sim_time is true, else from the wall clock. Return whether that worked.

    init_node does the same, unless it is called with ``disable_rostime``.
    """
    return rospy.impl.simtime.init_simtime()


def is_wall_time() -> bool:
    """Return whether rospy takes its time from the wall clock."""
    return rospy.rostime.is_wallclock()


def shutting_down() -> bool:
    """Return whether the shutdown has started; rospy.is_shutdown() is true only after some hooks have run."""
    return rospy.core.is_shutdown_requested() or rospy.core.is_shutdown()


def limit_calls_of_master(seconds: float) -> None:
    """Limit the time [s] that rospy waits for the master. Call it at the shutdown, which unregisters the node.

    The fault: a node does not end while the master hangs, or while another thread calls it on the same connection.
    """
    uri = rosgraph.get_master_uri()
    rospy.core._xmlrpc_cache[uri] = xmlrpc.client.ServerProxy(uri, transport=_ShutdownTransport(seconds))


class _ShutdownTransport(LimitedTransport):
    """A connection for each call; raises ProtocolError for OSErrors, which rospy's shutdown would print."""

    def request(self, host: Any, *arguments: Any, **options: Any) -> Any:
        try:
            with contextlib.closing(LimitedTransport(self.limit)) as own:  # another thread may be calling, too
                return own.request(host, *arguments, **options)
        except OSError as error:
            raise xmlrpc.client.ProtocolError(host, 0, str(error), {}) from None


def end_registering(timeout: float) -> None:
    """End a registration that has not succeeded after ``timeout`` [s], because the shutdown needs its lock.

    The fault: while no master answers, rospy retries until it shuts down, and holds that lock all the time.
    """
    for manager in (get_topic_manager(), get_service_manager()):
        if manager.lock.acquire(timeout=timeout):
            manager.lock.release()
        else:
            rospy.core._shutdown_flag = True


def wait_for_shutdown() -> None:
    """Wait until rospy.signal_shutdown has called all hooks, if another thread is executing it."""
    with rospy.core._shutdown_lock:
        pass


def shut_down_by(function: Callable[[str], Any]) -> None:
    """Call ``function(reason)`` when the master or another node (rosnode kill) requests a shutdown, and answer them.

    The fault: a master that does not know of a node's end sends the request to the present owner of the port. So a
    request for another node is ignored.
    """
    def shutdown(self: Any, caller_id: str, msg: str = '') -> Tuple[int, str, int]:
        print(f'shutdown request: {msg}')
        meant = re.match(r'\[(/\S*)\] Reason: ', str(msg))  # a master begins with the name of the node
        if meant and meant.group(1) != self.name:
            rospy.logwarn('Ignored a shutdown request for %s', meant.group(1))
            return 0, f'this is {self.name}', 0
        function(f'external shutdown request from [{caller_id}]: [{msg}]')
        return 1, 'shutdown', 0
    rospy.impl.masterslave.ROSHandler.shutdown = shutdown
