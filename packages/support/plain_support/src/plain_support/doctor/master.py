"""Ask a ROS master for its registrations, by XML-RPC with a time limit and without ROS."""
import http.client
import xmlrpc.client
from typing import Any, Container, Dict, List, NamedTuple, Tuple

CALLER = '/ros_doctor'


class NoAnswer(Exception):
    """Nothing answers in time."""


class NoMaster(Exception):
    """The program that answers is not a ROS master."""


class Graph(NamedTuple):
    """The registrations of a master.

    pid         the master's process number
    nodes       {name: XML-RPC address}
    services    {name: TCP address}
    publishers  {topic: names of nodes}
    parameters  the tree of parameters
    subscribers {topic: names of nodes}
    types       {topic: the type that the first or the last publisher has}
    """

    pid: int
    nodes: Dict[str, str]
    services: Dict[str, str]
    publishers: Dict[str, List[str]]
    parameters: Dict[str, Any]
    subscribers: Dict[str, List[str]] = {}
    types: Dict[str, str] = {}

    def of(self, nodes: Container[str]) -> 'Graph':
        """Return the graph with only the topics of these nodes."""
        publishers, subscribers = ({topic: kept for topic, users in topics.items()
                                    if (kept := [node for node in users if node in nodes])}
                                   for topics in (self.publishers, self.subscribers))
        return self._replace(publishers=publishers, subscribers=subscribers)


def ask(uri: str, timeout: float) -> Graph:
    """Return the Graph of the master at ``uri``; raise NoAnswer, each request after ``timeout`` [s], or NoMaster."""
    try:
        return _ask(xmlrpc.client.ServerProxy(uri, transport=_Transport(timeout)))
    except OSError as error:
        raise NoAnswer(str(error)) from None
    except (xmlrpc.client.Error, http.client.HTTPException, ValueError, TypeError, LookupError) as error:
        raise NoMaster(str(error)) from None
    except Exception as error:  # XML parsers have exceptions of their own
        raise NoMaster(str(error)) from None


def _ask(master: xmlrpc.client.ServerProxy) -> Graph:
    pid = _value(master.getPid(CALLER))
    published, subscribed, offered = _value(master.getSystemState(CALLER))
    names = sorted({node for topics in (published, subscribed, offered) for _, nodes in topics for node in nodes})
    services = sorted(name for name, _ in offered)
    return Graph(pid, _look_up(master, 'lookupNode', names), _look_up(master, 'lookupService', services),
                 dict(published), _value(master.getParam(CALLER, '/')), dict(subscribed),
                 dict(_value(master.getTopicTypes(CALLER))))


def types_of_node(uri: str, timeout: float) -> Dict[str, str]:
    """Return {topic: type} of all topics of the node at ``uri``; empty if it does not answer."""
    node = xmlrpc.client.ServerProxy(uri, transport=_Transport(timeout))
    try:
        return {**dict(_value(node.getSubscriptions(CALLER))), **dict(_value(node.getPublications(CALLER)))}
    except Exception:  # as in ask()
        return {}


def _look_up(master: xmlrpc.client.ServerProxy, method: str, names: List[str]) -> Dict[str, str]:
    """Return {name: address}, without those that have ended in the meantime."""
    if not names:
        return {}
    calls = xmlrpc.client.MultiCall(master)
    for name in names:
        getattr(calls, method)(CALLER, name)
    answers: Any = calls()
    return {name: uri for name, (code, _, uri) in zip(names, answers) if code == 1}


def _value(answer: Any) -> Any:
    code, reason, value = answer
    if code != 1:
        raise ValueError(reason)
    return value


class _Transport(xmlrpc.client.Transport):
    """HTTP with a time limit [s]; it does not retry."""

    def __init__(self, timeout: float) -> None:
        super().__init__()
        self._timeout = timeout

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = self._timeout
        return connection

    def request(self, host: Any, handler: str, request_body: Any, verbose: bool = False) -> Tuple[Any, ...]:
        return self.single_request(host, handler, request_body, verbose)
