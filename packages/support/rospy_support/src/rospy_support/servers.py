"""Protect the servers of a node, so that one peer cannot block the others; for callers of rospy.init_node.

Each module that is used here names the fault that it guards against.
"""
import functools
import resource
import sys
import threading
from socket import socket as Socket
from typing import Any, Callable

import rospy

from rospy_support import rospy_internals
from rospy_support.inbound import SocketWatch
from rospy_support.service_connection import SIZE_LIMIT
from rospy_support.slave_server import SlaveServer
from rospy_support.tcpros_server import TcprosServer
from rospy_support.throttle import WallThrottle

MANY_FILES = 65536  # file descriptors
NEXT, AGAIN = 1.0, 10.0  # [s] between two lines about peers, if their texts differ or are the same
REMINDER = 600.0  # [s] between two lines about file descriptors


def allow_many_files() -> None:
    """Raise the soft limit of open files, which is often only 1024.

    The fault: a thousand turtles need 3,000, and a node without a free one accepts no connection.
    """
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    limit = MANY_FILES if hard == resource.RLIM_INFINITY else min(hard, MANY_FILES)
    if soft != resource.RLIM_INFINITY and soft < limit:
        resource.setrlimit(resource.RLIMIT_NOFILE, (limit, hard))


@functools.lru_cache(maxsize=None)
def protect() -> None:
    """Let a SocketWatch read all incoming connections of this process, and allow many. Call it before init_node.

    With an unknown version of rospy, warn and keep rospy's own servers.
    """
    allow_many_files()
    unfit = rospy_internals.misfits()
    if unfit:
        print(f'This rospy ({rospy_internals.version()}) differs from those that rospy_support knows, so that idle '
              f'connections can block this node: {"; ".join(unfit)}', file=sys.stderr)
        return
    report = Report()
    watch = SocketWatch(report)

    def start(listening: Socket, topic_handler: Callable[..., Any]) -> None:
        watch.listen(listening, TcprosServer(watch, topic_handler).serve)
    rospy_internals.replace_tcpros_server(start, watch.close)
    rospy_internals.replace_slave_server(functools.partial(SlaveServer, watch))
    rospy_internals.limit_publishers()
    rospy_internals.tell_connections_apart()
    rospy_internals.limit_messages(SIZE_LIMIT, functools.partial(report, 'refused'))


class Report:
    """Logs warnings about peers: a new text after NEXT, the same one after AGAIN, the one about files after REMINDER.

    The fault: a peer that fails again and again fills the log. Each line is logged in a separate thread, because the
    thread of a SocketWatch must not wait for a terminal.
    """

    def __init__(self, log: Callable[..., Any] = rospy.logwarn) -> None:
        self._log, self._refused, self._files = log, WallThrottle(AGAIN), WallThrottle(REMINDER)

    def __call__(self, kind: str, text: str) -> None:
        """Log a text; ``kind`` is 'descriptors' or 'refused'."""
        due = self._files.due() if kind == 'descriptors' else self._refused.due(text=text, changed=NEXT)
        if due:
            threading.Thread(target=self._log, args=('%s', text), daemon=True).start()
