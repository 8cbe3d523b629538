"""The dead man's switch: stops what a client drives if the client disconnects or is silent for too long.

Threading contract: one thread uses a Deadman.
"""
import math
from typing import List, Set


class Deadman:
    """Watches the velocities of one client."""

    def __init__(self, timeout: float = 0.0) -> None:
        """``timeout`` [s] without a message of the client; 0: the client is not watched."""
        self.timeout = timeout
        self.moving: Set[str] = set()  # the topics on which the client's last velocity was not zero
        self._heard = -math.inf

    @property
    def watching(self) -> bool:
        """Whether the client is watched."""
        return self.timeout > 0

    def heard(self, now: float) -> None:
        self._heard = now

    def drove(self, topic: str, zero: bool) -> None:
        if zero:
            self.moving.discard(topic)
        else:
            self.moving.add(topic)

    def expired(self, now: float) -> List[str]:
        """Return the topics that need a zero velocity because the client is silent; each once."""
        return self.gone() if now - self._heard > self.timeout else []

    def gone(self) -> List[str]:
        """Return the topics that need a zero velocity because the client has gone; each once."""
        topics = sorted(self.moving) if self.watching else []
        if topics:
            self.moving.clear()
        return topics
