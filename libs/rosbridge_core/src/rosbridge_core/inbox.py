"""What a client has sent and the server has not done yet: velocities first, newest only, everything else in order.

A client that sends faster than the server can work must not delay the zero velocity with which it stops a robot. Of
the velocities for a topic only the newest is kept; it overtakes other operations.

Threading contract: one thread uses an Inbox.
"""
import collections
from typing import Any, Deque, Dict, Optional, Tuple

from rosbridge_core.operations import Operation

MOST = 1000  # operations that wait; a client is not read meanwhile
VELOCITIES = 'geometry_msgs/Twist', 'geometry_msgs/TwistStamped'


class Inbox:
    """The operations of one client that wait."""

    def __init__(self) -> None:
        self._velocities: Dict[str, Operation] = {}
        self._others: Deque[Tuple[str, Operation]] = collections.deque()

    def put(self, name: str, operation: Operation, urgent: bool) -> None:
        """Put a checked operation; ``urgent``: it publishes a velocity on a topic that is advertised."""
        if urgent:
            self._velocities[operation['topic']] = operation
        else:
            self._others.append((name, operation))

    def take(self) -> Optional[Tuple[str, Operation]]:
        """Return the next operation, or None."""
        return self.take_velocity() or (self._others.popleft() if self._others else None)

    def take_velocity(self) -> Optional[Tuple[str, Operation]]:
        """Return the next velocity, or None."""
        if self._velocities:
            zero = (topic for topic, operation in self._velocities.items() if is_zero(operation.get('msg', {})))
            topic = next(zero, None) or next(iter(self._velocities))
            return 'publish', self._velocities.pop(topic)
        return None

    def __len__(self) -> int:
        return len(self._velocities) + len(self._others)

    @property
    def full(self) -> bool:
        """Whether the client has to wait."""
        return len(self._others) >= MOST


def is_zero(twist: Any) -> bool:
    """Return whether a Twist or TwistStamped, as a dict, stops; one without numbers does."""
    if not isinstance(twist, dict):
        return False
    twist = twist.get('twist', twist)
    parts = [twist.get(part, {}) for part in ('linear', 'angular')] if isinstance(twist, dict) else []
    return all(isinstance(part, dict) and not any(part.values()) for part in parts)
