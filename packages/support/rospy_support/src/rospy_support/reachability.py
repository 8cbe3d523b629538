"""Warn if nodes on other machines cannot connect to this one; rospy reports nothing.

A node tells the master its address: ROS_HOSTNAME, else ROS_IP, else the machine's name.
A subscriber on another machine connects to that address. If it is wrong, no message arrives and there is no error.

Threading contract: ``watch`` starts a thread, which only logs.
"""
import http.client
import threading
import time
import xmlrpc.client
from typing import Optional, Set, Tuple
from urllib.parse import urlsplit

import rosgraph
import rospy

from plain_support.doctor import addresses, findings, registrations
from rospy_support import rospy_internals, threads
from rospy_support.throttle import WallThrottle

PERIOD = 3.0  # [s] between two checks; a connection takes far less
SHARE = 0.01  # of the time that checks may take: one check with a thousand turtles takes 0.2 s
LOG_TOPIC = '/rosout'
REMINDER = 30.0  # [s] between two warnings of the same kind


def watch(period: float = PERIOD) -> threading.Thread:
    """Warn at once if this node's address cannot be right, and later about topics that stay unconnected."""
    wrong = addresses.wrong_address()
    if wrong:
        rospy.logwarn('%s', wrong)
    ended, reminders = threading.Event(), WallThrottle(REMINDER)
    rospy.on_shutdown(ended.set)

    def check() -> None:
        before: Set[Tuple[str, str]] = set()
        pause = period
        while not ended.wait(pause):
            start = time.monotonic()
            try:
                now = unconnected()
            except (OSError, rosgraph.MasterException, xmlrpc.client.Error, http.client.HTTPException):
                continue  # without a master there is nothing to compare with
            finally:
                pause = pause_after(time.monotonic() - start, period)
            for topic, others in sorted(now & before):  # twice in a row: it is not just connecting
                reminders.warn((topic, others), '%s', _silence(topic, others))
            before = now
    return threads.keep_running('reachability', check)


def pause_after(took: float, period: float) -> float:
    """Return how long [s] to wait after a check that took ``took`` [s]."""
    return max(period, took / SHARE)


def unconnected() -> Set[Tuple[str, str]]:
    """Return {(topic, nodes)}: topics of this node without a connection, though the master knows the other nodes.

    ``nodes`` is a text: their names, separated by commas. Raises OSError or a rosgraph.MasterException if the master
    does not answer.
    """
    published = rospy_internals.unconnected_publications() - {LOG_TOPIC}
    subscribed = rospy_internals.unconnected_subscriptions()
    if not published and not subscribed:
        return set()
    publishers, subscribers, _ = rosgraph.Master(rospy.get_name()).getSystemState()
    found = set()
    for own, others in ((published, subscribers), (subscribed, publishers)):
        for topic, nodes in others:
            elsewhere = sorted(set(nodes) - {rospy.get_name()})
            if topic in own and elsewhere:
                found.add((topic, ', '.join(elsewhere)))
    return found


def _silence(topic: str, nodes: str) -> str:
    gone = [str(finding) for finding in map(_gone, nodes.split(', ')) if finding]
    if gone:
        return f'{topic}: {" ".join(gone)}'
    master = addresses.master_address()
    return (f'{topic}: {nodes} is known to the master, but no connection exists. This node says that it is reached '
            f'at {addresses.announced()} ({addresses.source()}), its master is {rosgraph.get_master_uri()}. '
            f'Check that {nodes} runs (rosnode ping; rosnode cleanup if not) and that ROS_IP is right on both sides; '
            f'{addresses.remedy(master.host if master else "localhost")}')


def _gone(node: str) -> Optional[findings.Finding]:
    """Return a finding about a node of this machine that has ended without unregistering; None for others."""
    master, service = rosgraph.Master(rospy.get_name()), f'{node}/{registrations.SIGN}'
    try:
        uri, offered = master.lookupNode(node), master.lookupService(service)
    except (OSError, rosgraph.MasterException, xmlrpc.client.Error, http.client.HTTPException):
        return None
    here = addresses.is_here(urlsplit(offered).hostname or '')
    if not here or registrations.offers(service, offered, PERIOD):
        return None
    return findings.stale_registration(node, uri)
