"""Count the messages of a topic that local subscribers have not read yet. Linux only.

A node that gets no CPU time does not read. The tables of TCP sockets (proc(5), /proc/net/tcp) contain the number of
unread bytes, in the row of the subscriber's end of the connection.
"""
from __future__ import annotations

import time
from typing import Iterable

import rospy

from rospy_support import rospy_internals

MAX_LAG = 0.2  # [s] of simulated time that a node may be behind /clock
CHECK_PERIOD = 0.1  # [s] of wall time between two checks
TABLES = '/proc/net/tcp', '/proc/net/tcp6'


class LagMonitor:
    """Finds nodes that are too far behind /clock, for a simulator that does not wait for them."""

    def __init__(self, clock: rospy.Publisher, size: int, step: float) -> None:
        """``clock`` publishes messages of ``size`` [bytes], one every ``step`` [s] of simulated time."""
        self._clock = clock
        self._size = size
        self._step = step
        self._next_check = 0.0  # [s, monotonic] time of the next check
        self.late = 0  # checks that found a node behind
        self.busy = ''  # the nodes that were behind in the last of these checks

    def lag(self) -> float:
        """Return how far [s of simulated time] the slowest node is behind; 0.0 if none is, or no check is due."""
        now = time.monotonic()
        if now < self._next_check:
            return 0.0
        self._next_check = now + CHECK_PERIOD
        limit = MAX_LAG / self._step
        behind = {node: number for node, number in unread(self._clock, self._size).items() if number > limit}
        if not behind:
            return 0.0
        self.late += 1
        self.busy = ', '.join(sorted(behind))
        return max(behind.values()) * self._step


def unread(publisher: rospy.Publisher, size: int) -> dict[str, int]:
    """Return {node: number of unread messages} of the local subscribers of a rospy.Publisher.

    ``size`` [bytes] is that of one message.
    """
    ports = {}
    for connection in list(rospy_internals.connections(publisher)):
        try:
            ports[connection.socket.getpeername()[1], connection.socket.getsockname()[1]] = connection.endpoint_id
        except (OSError, AttributeError):  # gone
            continue
    if not ports:
        return {}
    waiting: dict[tuple[int, int], int] = {}
    for path in TABLES:
        try:
            with open(path, encoding='ascii') as table:
                waiting.update(receive_queues(table))
        except OSError:  # no such table here
            continue
    return {node: waiting[pair] // size for pair, node in ports.items() if pair in waiting}


def receive_queues(table: Iterable[str]) -> dict[tuple[int, int], int]:
    """Return {(local port, remote port): unread bytes} from the lines of a table; the first line is its heading."""
    queues = {}
    for line in list(table)[1:]:
        _, local, remote, _, lengths = line.split()[:5]
        queues[_port(local), _port(remote)] = int(lengths.partition(':')[2], 16)
    return queues


def _port(address: str) -> int:
    return int(address.rpartition(':')[2], 16)
