"""What runs at the ROS master, whoever has started it, and how it is ended.

Threading contract: the functions wait for other processes, so they are called in threads of the loop's executor.
"""
import contextlib
import http.client
import os
import time
import xmlrpc.client
from typing import Any, Callable, Collection, Dict, NamedTuple, Sequence, Set
from urllib.parse import urlsplit

import psutil
import rospy

from plain_support.doctor import addresses, registrations
from rospy_support import nodes
from rospy_support.limited_transport import LimitedTransport
from rospy_support.master import Master, NoMaster

ANSWER_TIMEOUT = 1.0  # [s] of a request to the master or a node
END_TIMEOUT = 20.0  # [s] in which programs must end that were asked to
POLL = 0.2  # [s]
FAULTS = OSError, http.client.HTTPException, xmlrpc.client.Error


class Seen(NamedTuple):
    """``holders``: {node, published topic or service: nodes that run}; ``values``: {parameter: value}."""

    holders: Dict[str, Set[str]]
    values: Dict[str, object]


NOTHING = Seen({}, {})


def look(names: Collection[str], parameters: Sequence[str] = ()) -> Seen:
    """Return the Seen of the nodes, topics and services ``names``, and of parameters; NOTHING without a master."""
    master = Master(ANSWER_TIMEOUT)
    try:
        (_, _, (publishers, subscribers, services)), = master.request([('getSystemState',)])
        registered = {node for _, users in (*publishers, *subscribers, *services) for node in users}
        holders = {name: {name} & registered for name in names}
        for name, users in (*publishers, *services):
            if name in holders:
                holders[name] |= set(users)
        holders = {name: users for name, users in holders.items() if users}
        alive = {node for node in sorted(set().union(*holders.values())) if _runs(master, node)}
        answers = master.request([('getParam', name) for name in parameters])
    except (NoMaster, TypeError, ValueError):
        return NOTHING
    values = {name: value for name, (code, _, value) in zip(parameters, answers) if code == 1}
    return Seen({name: users & alive for name, users in holders.items() if users & alive}, values)


def _runs(master: Any, node: str) -> bool:
    """Return whether a node answers; one that was killed is still registered."""
    service = f'{node}/{registrations.SIGN}'
    (code, _, uri), = master.request([('lookupService', service)])
    return code == 1 and registrations.offers(service, uri, ANSWER_TIMEOUT)


def end(nodes_left: Callable[[], Set[str]]) -> Set[str]:
    """Let the nodes end that ``nodes_left()`` returns; return those that still run after END_TIMEOUT.

    A roslaunch may start one again until one that it requires has ended, so each is asked as often as it comes.
    """
    master, deadline = Master(ANSWER_TIMEOUT), time.monotonic() + END_TIMEOUT
    requested: Set[str] = set()
    while True:
        left = nodes_left()
        if not left or time.monotonic() > deadline:
            return left
        with contextlib.suppress(NoMaster):
            for node in sorted(left):
                (code, _, uri), = master.request([('lookupNode', node)])
                if code == 1 and uri not in requested:
                    requested.add(uri)
                    with contextlib.suppress(*FAULTS):
                        _node(uri).shutdown(rospy.get_name(), 'a user of the page has ended it')
        time.sleep(POLL)


def started_with_this_page(names: Collection[str]) -> Set[str]:
    """Return those nodes that the roslaunch has started that also started this process; it may end all together.

    The name of the parent's command does not tell: a roslaunch may be forked from another program.
    """
    found: Set[str] = set()
    if not nodes.launched():
        return found
    master = Master(ANSWER_TIMEOUT)
    for node in names:
        with contextlib.suppress(NoMaster, psutil.Error, *FAULTS):
            (code, _, uri), = master.request([('lookupNode', node)])
            if code == 1 and addresses.is_here(urlsplit(uri).hostname or ''):
                _, _, number = _node(uri).getPid(rospy.get_name())
                if psutil.Process(number).ppid() == os.getppid():
                    found.add(node)
    return found


def _node(uri: str) -> Any:
    return xmlrpc.client.ServerProxy(uri, transport=LimitedTransport(ANSWER_TIMEOUT))
