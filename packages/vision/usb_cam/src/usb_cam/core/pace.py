"""Schedule the images of a file on a fixed time grid, so that delays do not add up."""
import time
from typing import Callable


class FrameSchedule:
    """Deadlines at ``rate`` [Hz], the first one at once; ``clock`` returns seconds and never goes back."""

    def __init__(self, rate: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._period, self._clock = 1.0 / rate, clock
        self.restart()

    def restart(self) -> None:
        """Start a new grid now, after a break."""
        self._start, self._slot = self._clock(), 0

    def time_left(self) -> float:
        """Return the time [s] until the next image is due; 0 or less: it is due."""
        return self._start + self._slot * self._period - self._clock()

    def advance(self) -> None:
        """Advance to the next deadline; skip missed ones, so that no burst of images follows."""
        missed = max(0, int(-self.time_left() / self._period))
        self._slot += 1 + missed
