"""How long something has been waited for, on a machine that may stand still meanwhile.

A virtual machine that is suspended, or a process that is stopped, finds that seconds have passed in which nobody
could have answered. Counted is only the time in which this process ran: it looks often, and a longer gap between two
looks counts no more than ``LONGEST_GAP``.
"""
import time
from typing import Callable

LONGEST_GAP = 0.1  # [s]


class ActiveTimer:
    """Counts the time since it was made: ``waited`` [s] while this process ran, ``lost`` [s] while it stood still."""

    def __init__(self, monotonic: Callable[[], float] = time.monotonic) -> None:
        """``monotonic`` [s] is the wall clock."""
        self.waited = self.lost = 0.0
        self._monotonic, self._last = monotonic, monotonic()

    def look(self) -> float:
        """Return ``waited``; to be called more often than every LONGEST_GAP."""
        now = self._monotonic()
        gap, self._last = now - self._last, now
        self.waited += min(gap, LONGEST_GAP)
        self.lost += max(0.0, gap - LONGEST_GAP)
        return self.waited
