"""Many calls to the ROS master in one request, with a timeout, for topics and services that appear together.

rospy itself makes one request for each topic and service, and has no timeout.

Threading contract: one thread at a time uses a Master.
"""
import http.client
import xmlrpc.client
from typing import Any, Dict, Iterable, List, Optional, Sequence

import rosgraph
import rospy

from rospy_support import rospy_internals
from rospy_support.limited_transport import LimitedTransport
from rospy_support.rospy_internals import Call

TIMEOUT = 5.0  # [s] for the answer to a request
MAX_CALLS = 600  # per request, because the master answers no other request in the meantime


class NoMaster(Exception):
    """The master does not answer; the text says at which address."""


class Master:
    """The ROS master, called through a connection that stays open."""

    def __init__(self, timeout: float = TIMEOUT) -> None:
        """``timeout`` [s] of a request."""
        self._timeout = timeout
        self._proxy: Optional[xmlrpc.client.ServerProxy] = None
        self._transport = _Transport(timeout)

    def register(self, calls: List[Call]) -> None:
        """Make the calls of rospy_internals.collected_registrations; raise NoMaster."""
        rospy_internals.registered(calls, [value if code == 1 else None for code, _, value in self.request(calls)])

    def unregister(self, calls: List[Call]) -> None:
        """Make the calls of rospy_internals.collected_unregistrations, ignoring the answers; raise NoMaster."""
        self.request(calls, unread=True)

    def parameters(self, names: Iterable[str]) -> Dict[str, Any]:
        """Return {resolved name: value} of the parameters that are set; raise NoMaster."""
        resolved = [rospy.resolve_name(name) for name in names]
        answers = self.request([('getParam', name) for name in resolved])
        return {name: value for name, (code, _, value) in zip(resolved, answers) if code == 1}

    def request(self, calls: Sequence[Call], unread: bool = False) -> List[Any]:
        """Make calls (method, arguments after the caller's name); return the answers, each [code, text, value].

        Raise NoMaster; some of the calls may then have been made. With ``unread`` the answers are not parsed and []
        is returned, which halves the time of thousands of calls.
        """
        answers: List[Any] = []
        for start in range(0, len(calls), MAX_CALLS):
            answers += self._request(calls[start:start + MAX_CALLS], unread)
        return answers

    def _request(self, calls: Sequence[Call], unread: bool) -> List[Any]:
        if self._proxy is None:
            self._proxy = xmlrpc.client.ServerProxy(rosgraph.get_master_uri(), transport=self._transport)
        multicall = xmlrpc.client.MultiCall(self._proxy)
        for method, *arguments in calls:
            getattr(multicall, method)(rospy.get_name(), *arguments)
        self._transport.unread = unread
        try:
            return list(multicall())  # type: ignore[call-overload]  # iterated by its __getitem__
        except (OSError, http.client.HTTPException, xmlrpc.client.Error) as error:
            self._proxy('close')()
            self._proxy = None
            raise NoMaster(f'no ROS master answers at {rosgraph.get_master_uri()} ({error})') from None


class _Transport(LimitedTransport):
    """With ``unread`` it returns an empty list instead of the answers."""

    unread = False

    def parse_response(self, response: http.client.HTTPResponse) -> Any:
        if not self.unread:
            return super().parse_response(response)
        response.read()
        return ([],)
