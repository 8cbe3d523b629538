"""A timer that does not count the time in which the machine stood still.

When a virtual machine is suspended, or a process is stopped, seconds pass in which nothing can answer. This timer
counts only the time in which this process ran: it is checked often, and a longer gap between two checks counts only as
``MAX_GAP``.
"""
import time
from typing import Callable

MAX_GAP = 0.1  # [s]


class ActiveTimer:
    """Counts the time since it was made: ``waited`` [s] while this process ran, ``lost`` [s] while it stood still."""

    def __init__(self, monotonic: Callable[[], float] = time.monotonic) -> None:
        """``monotonic`` [s] is the wall clock."""
        self.waited = self.lost = 0.0
        self._monotonic, self._last = monotonic, monotonic()

    def elapsed(self) -> float:
        """Return ``waited``. Call it more often than every MAX_GAP."""
        now = self._monotonic()
        gap, self._last = now - self._last, now
        self.waited += min(gap, MAX_GAP)
        self.lost += max(0.0, gap - MAX_GAP)
        return self.waited
