"""Many calls of the ROS master in one request, with a time limit: registrations of what comes and goes together.

rospy asks the master once for each topic and service, and waits for it without end.

Threading contract: one thread at a time uses a Master.
"""
import http.client
import xmlrpc.client

import rosgraph
import rospy

from kinematic_ros import rospy_internals

TIMEOUT = 5.0  # [s] in which a request must be answered
MOST_CALLS = 600  # in one request: the master answers nobody else meanwhile


class NoMaster(Exception):
    """The master does not answer; the text says where it was looked for."""


class Master:
    """The ROS master, asked over a connection that stays open."""

    def __init__(self, timeout=TIMEOUT):
        """``timeout`` [s] of a request."""
        self._timeout = timeout
        self._proxy = None

    def register(self, calls):
        """Make the calls of rospy_internals.collected_registrations; raise NoMaster."""
        for (method, name, *_), (_, _, value) in zip(calls, self.request(calls)):
            if method == 'registerSubscriber' and value:
                rospy_internals.new_publishers(name, value)

    def parameters(self, names):
        """Return {resolved name: value} of those parameters that are set; raise NoMaster."""
        resolved = [rospy.resolve_name(name) for name in names]
        answers = self.request([('getParam', name) for name in resolved])
        return {name: value for name, (code, _, value) in zip(resolved, answers) if code == 1}

    def request(self, calls):
        """Make calls, each (method, its arguments after the caller's name); return their answers: [code, text, value].

        Raise NoMaster, where some of the calls may have been made.
        """
        answers = []
        for begin in range(0, len(calls), MOST_CALLS):
            answers += self._request(calls[begin:begin + MOST_CALLS])
        return answers

    def _request(self, calls):
        if self._proxy is None:
            self._proxy = xmlrpc.client.ServerProxy(rosgraph.get_master_uri(), transport=_Transport(self._timeout))
        several = xmlrpc.client.MultiCall(self._proxy)
        for method, *arguments in calls:
            getattr(several, method)(rospy.get_name(), *arguments)
        try:
            return list(several())
        except (OSError, http.client.HTTPException, xmlrpc.client.Error) as error:
            self._proxy('close')()
            self._proxy = None
            raise NoMaster(f'no ROS master answers at {rosgraph.get_master_uri()} ({error})') from None


class _Transport(xmlrpc.client.Transport):
    """HTTP with a time limit."""

    def __init__(self, timeout):
        super().__init__()
        self._timeout = timeout

    def make_connection(self, host):
        connection = super().make_connection(host)
        connection.timeout = self._timeout
        return connection
