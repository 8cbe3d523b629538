"""The shutdown of a node: who requests it, and limits for the time that it takes."""
import contextlib
import re
import xmlrpc.client

import rosgraph
import rospy
import rospy.core
import rospy.impl.masterslave
from rospy.impl.registration import get_service_manager, get_topic_manager

from rospy_support.limited_transport import LimitedTransport


def shutting_down():
    """Return whether the shutdown has started; rospy.is_shutdown() is true only after some hooks have run."""
    return rospy.core.is_shutdown_requested() or rospy.core.is_shutdown()


def limit_calls_of_master(seconds):
    """Limit the time [s] that rospy waits for the master. Call it at the shutdown, which unregisters the node.

    The fault: a node does not end while the master hangs, or while another thread calls it on the same connection.
    """
    uri = rosgraph.get_master_uri()
    rospy.core._xmlrpc_cache[uri] = xmlrpc.client.ServerProxy(uri, transport=_ShutdownTransport(seconds))


class _ShutdownTransport(LimitedTransport):
    """A connection for each call; raises ProtocolError for OSErrors, which rospy's shutdown would print."""

    def request(self, host, *arguments, **options):
        try:
            with contextlib.closing(LimitedTransport(self.limit)) as own:  # another thread may be calling, too
                return own.request(host, *arguments, **options)
        except OSError as error:
            raise xmlrpc.client.ProtocolError(host, 0, str(error), {}) from None


def end_registering(timeout):
    """End a registration that has not succeeded after ``timeout`` [s], because the shutdown needs its lock.

    The fault: while no master answers, rospy retries until it shuts down, and holds that lock all the time.
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

    The fault: a master that does not know of a node's end sends the request to the present owner of the port. So a
    request for another node is ignored.
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
