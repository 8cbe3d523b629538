"""The dead man's switch: stops what a client drives if the client disconnects or is silent for too long.

Threading contract: one thread uses a Deadman.
"""
import math
from typing import FrozenSet, List, Set


class Deadman:
    """Watches the velocities of one client."""

    def __init__(self, timeout: float = 0.0) -> None:
        """``timeout`` [s] without a message of the client; 0: the client is not watched."""
        self._timeout = timeout
        self._moving: Set[str] = set()
        self._heard = -math.inf

    @property
    def watching(self) -> bool:
        """Whether the client is watched."""
        return self._timeout > 0

    @property
    def timeout(self) -> float:
        """How long [s] the client may be silent."""
        return self._timeout

    @property
    def moving(self) -> FrozenSet[str]:
        """The topics on which the client's last velocity was not zero."""
        return frozenset(self._moving)

    def watch(self, timeout: float) -> None:
        """Change the timeout, as the client itself has asked for."""
        self._timeout = timeout

    def heard(self, now: float) -> None:
        """Note that the client has sent something."""
        self._heard = now

    def drove(self, topic: str, zero: bool) -> None:
        """Note that the client has published a velocity."""
        if zero:
            self._moving.discard(topic)
        else:
            self._moving.add(topic)

    def expired(self, now: float) -> List[str]:
        """Return the topics that need a zero velocity because the client is silent; each once."""
        return self.gone() if now - self._heard > self._timeout else []

    def gone(self) -> List[str]:
        """Return the topics that need a zero velocity because the client has gone; each once."""
        topics = sorted(self._moving) if self.watching else []
        if topics:
            self._moving.clear()
        return topics
