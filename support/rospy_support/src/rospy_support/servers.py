"""Protect the servers of a node, so that one peer cannot block the others; for callers of rospy.init_node.

rospy accepts connections and reads their headers in one thread, so a peer that connects and sends nothing blocks all
others. Here a SocketWatch reads them (inbound.py).
"""
import collections
import functools
import resource
import sys
import threading
import time

import rospy

from rospy_support import rospy_internals
from rospy_support.inbound import SocketWatch
from rospy_support.service_connection import SIZE_LIMIT
from rospy_support.slave_server import SlaveServer
from rospy_support.tcpros_server import HEADER_LIMIT, TcprosServer

MANY_FILES = 65536  # file descriptors
MOST_PUBLISHERS = 1000  # of a topic
MOST_LINES, PERIOD = 5, 10.0  # log lines about peers per period [s]
REMINDER = 600.0  # [s] between two lines about file descriptors


def allow_many_files():
    """Raise the soft limit of open files: each connection takes one, and the limit is often only 1024."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = MANY_FILES if hard == resource.RLIM_INFINITY else min(hard, MANY_FILES)
    if soft != resource.RLIM_INFINITY and soft < wanted:
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))


@functools.lru_cache(maxsize=None)
def protect():
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

    def start(listening, topic_handler):
        watch.listen(listening, TcprosServer(watch, topic_handler).serve)
    rospy_internals.replace_tcpros_server(start, watch.close)
    rospy_internals.replace_slave_server(functools.partial(SlaveServer, watch))
    rospy_internals.limit_publishers(MOST_PUBLISHERS)
    rospy_internals.tell_connections_apart()
    rospy_internals.limit_lengths(HEADER_LIMIT, SIZE_LIMIT, functools.partial(report, 'refused'))


class Report:
    """Logs warnings about peers, at most MOST_LINES of a kind per PERIOD, and counts the others.

    Each line is logged in a separate thread, because logging asks the master for a parameter, and a terminal may block.
    """

    def __init__(self, monotonic=time.monotonic, log=rospy.logwarn):
        self._monotonic, self._log, self._lock = monotonic, log, threading.Lock()
        self._said = collections.defaultdict(collections.deque)  # kind: times of its lines [s, monotonic]
        self._left_out = collections.Counter()

    def __call__(self, kind, text):
        """Log a text; ``kind`` 'descriptors' is logged once in REMINDER."""
        most, period = (1, REMINDER) if kind == 'descriptors' else (MOST_LINES, PERIOD)
        with self._lock:
            now, said = self._monotonic(), self._said[kind]
            while said and said[0] <= now - period:
                said.popleft()
            if len(said) >= most:
                self._left_out[kind] += 1
                return
            said.append(now)
            left_out = self._left_out.pop(kind, 0)
        if left_out and kind != 'descriptors':
            text += f' ({left_out} more lines of this kind were left out.)'
        threading.Thread(target=self._log, args=('%s', text), daemon=True).start()
