"""Throttled log lines: each kind at most once per period of wall time.

rospy's own throttle uses ROS time, which a simulator may stop or run a thousand times as fast, and treats all lines of
one statement as one kind.
"""
import math
import threading
import time
from typing import Dict, Hashable, Optional, Tuple

import rospy


class WallThrottle:
    """Decides whether a line may be logged. Thread-safe."""

    def __init__(self, period: float) -> None:
        """``period`` [s] between two lines of a kind; math.inf: only the first one is due."""
        self._period = period
        self._lock = threading.Lock()
        self._logged: Dict[Hashable, Tuple[float, str]] = {}  # kind: (time of its last line [s, monotonic], its text)

    def due(self, kind: Hashable = '', text: str = '', changed: Optional[float] = None) -> bool:
        """Return whether a line of this kind may be logged now; if so, the next one is due a period later.

        ``changed`` [s] is the period of a line whose ``text`` differs from the last one's; by default the same.
        """
        now = time.monotonic()
        with self._lock:
            logged, before = self._logged.get(kind, (-math.inf, ''))
            if now < logged + (self._period if changed is None or text == before else changed):
                return False
            self._logged[kind] = now, text
            return True

    def forget(self, kind: Hashable) -> None:
        """Let the next line of this kind be due at once."""
        with self._lock:
            self._logged.pop(kind, None)

    def warn(self, kind: Hashable, text: str, *values: object) -> None:
        """Log a warning if it is due; ``values`` are formatted into ``text``."""
        if self.due(kind):
            rospy.logwarn(text, *values)
