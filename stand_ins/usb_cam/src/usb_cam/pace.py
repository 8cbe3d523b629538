"""When the next picture of a file is due: on a fixed grid of time, so that no delay adds up."""
import time


class Pace:
    """Deadlines ``rate`` [Hz] times a second, the first one at once; ``clock`` returns seconds that never go back."""

    def __init__(self, rate, clock=time.monotonic):
        self._period, self._clock = 1.0 / rate, clock
        self.restart()

    def restart(self):
        """Begin a new grid now, after a break."""
        self._begin, self._slot = self._clock(), 0

    def left(self):
        """Return the time [s] until the next picture is due; 0 or less: it is due."""
        return self._begin + self._slot * self._period - self._clock()

    def next(self):
        """Go on to the next deadline; those that have passed altogether are left out: no burst makes up for them."""
        missed = max(0, int(-self.left() / self._period))
        self._slot += 1 + missed
