"""The operations of a client that wait: velocities first, newest only, all others in order.

A client that sends faster than the server can work must not delay the zero velocity with which it stops a robot. Of
the velocities for a topic only the newest is kept, and it overtakes other operations. When too many other messages
wait to be published, the oldest are dropped, as in the queue of a ROS publisher.

Threading contract: one thread uses an Inbox.
"""
import collections
from typing import Any, Deque, Dict, NamedTuple, Optional, Tuple

from browser_servers.core.operations import Operation

MAX_OPERATIONS = 1000  # that wait beside messages; with more, the client is not read
MAX_MESSAGES = 5000  # that wait to be published
MAX_BYTES = 32 << 20  # [B] of all waiting operations
VELOCITIES = 'geometry_msgs/Twist', 'geometry_msgs/TwistStamped'


class _Waiting(NamedTuple):
    name: str
    operation: Operation
    size: int


class Inbox:
    """The operations of one client that wait."""

    def __init__(self) -> None:
        self._velocities: Dict[str, Operation] = {}
        self._others: Deque[_Waiting] = collections.deque()
        self._messages = self._size = 0

    def put(self, name: str, operation: Operation, urgent: bool, size: int = 0) -> int:
        """Put a checked operation of ``size`` [B]; return how many messages were dropped for it.

        ``urgent``: it publishes a velocity on a topic that is advertised.
        """
        if urgent:
            self._velocities[operation['topic']] = operation
            return 0
        self._others.append(_Waiting(name, operation, size))
        self._size += size
        self._messages += name == 'publish'
        dropped = 0
        while self._messages > MAX_MESSAGES or (self._size > MAX_BYTES and self._messages > 1):
            self._drop()
            dropped += 1
        return dropped

    def _drop(self) -> None:
        for index, waiting in enumerate(self._others):
            if waiting.name == 'publish':
                del self._others[index]
                self._forget(waiting)
                return

    def _forget(self, waiting: _Waiting) -> None:
        self._size -= waiting.size
        self._messages -= waiting.name == 'publish'

    def take(self) -> Optional[Tuple[str, Operation]]:
        velocity = self.take_velocity()
        if velocity is not None or not self._others:
            return velocity
        first = self._others.popleft()
        self._forget(first)
        return first.name, first.operation

    def take_velocity(self) -> Optional[Tuple[str, Operation]]:
        if self._velocities:
            zero = (topic for topic, operation in self._velocities.items() if is_zero(operation.get('msg', {})))
            topic = next(zero, None) or next(iter(self._velocities))
            return 'publish', self._velocities.pop(topic)
        return None

    def __len__(self) -> int:
        return len(self._velocities) + len(self._others)

    @property
    def full(self) -> bool:
        return len(self._others) - self._messages >= MAX_OPERATIONS or self._size > 2 * MAX_BYTES


def is_zero(twist: Any) -> bool:
    """Return whether a Twist or TwistStamped, as a dict, is zero; missing numbers count as zero."""
    if not isinstance(twist, dict):
        return False
    twist = twist.get('twist', twist)
    parts = [twist.get(part, {}) for part in ('linear', 'angular')] if isinstance(twist, dict) else []
    return all(isinstance(part, dict) and not any(part.values()) for part in parts)
