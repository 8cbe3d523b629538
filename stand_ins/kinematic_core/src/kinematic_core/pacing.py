"""When the next step of a simulator is due: fixed steps paced by wall time, faster or slower than it, or by hand.

Simulated time is counted in steps, never measured: step number n ends at BEGIN + n * step, whatever the wall clock did.

Two policies for steps that come late, because the machine was busy:

* simulated time *is* wall time for everybody else (``bounded`` false): late steps are made up for soon, so that no
  ground is lost; not in one burst, for after a stall of the whole machine a robot would drive blindly, and its watchdog
  strike, before a node had its turn;
* the simulator publishes its time, which is faster, and everybody follows it (``bounded`` true): so many late steps
  would leave the followers behind, so they are made up for at little more than the pace, and only as long as that is
  soon.

Threading contract: one thread calls ``wait``; ``pause``, ``resume``, ``request`` and ``close`` may come from any.
"""
import math
import threading
import time

BEGIN = 1_000_000_000  # [ns] simulated time before the first step; ROS takes 0 for 'no time yet'
LONGEST_CATCH_UP = 5.0  # [s] of wall time that is made up for; a longer gap was a suspended machine
LONGEST_BOUNDED_CATCH_UP = 0.5  # [s] likewise where others follow
LONGEST_SLEEP = 0.1  # [s] of wall time in which a pause or an end is noticed
FASTER = 3.0  # times the pace, at which late steps are made up for: commands at 10 Hz reach a watchdog of 0.5 s
FASTER_BOUNDED = 1.25  # likewise where others follow


class Pacer:
    """Waits for the steps of one simulator."""

    def __init__(self, step, rate=1.0, bounded=False, monotonic=time.monotonic, sleep=time.sleep):
        """``step`` [s] of simulated time; ``rate``: simulated seconds a wall second, math.inf: no waiting at all.

        ``monotonic`` [s] is the wall clock, ``sleep`` waits in it.
        """
        self.step, self.rate, self.bounded = step, rate, bounded
        self.steps = 0  # begun so far
        self.paused = False
        self._monotonic, self._sleep = monotonic, sleep
        self._period = step / rate  # [s] of wall time; 0 at math.inf
        self._closest = self._period / (FASTER_BOUNDED if bounded else FASTER)
        self._longest_catch_up = LONGEST_BOUNDED_CATCH_UP if bounded else LONGEST_CATCH_UP
        self._changed = threading.Condition()
        self._closed = False
        self._requested = 0  # steps by hand that are still to be made
        self._due = None  # [s] wall time of the next step
        self._last = -math.inf  # [s] wall time of the last one

    @property
    def nanoseconds(self):
        """Return the simulated time [ns] at the end of the step begun last."""
        return BEGIN + self.steps * round(self.step * 1e9)

    @property
    def standing(self):
        """Return whether no step is to be made, neither in time nor by hand."""
        return self.paused and not self._requested

    def pause(self):
        """Make no step any more until ``resume``, but those of ``request``."""
        self.paused = True

    def resume(self):
        """Go on from here; the time of the pause is not made up for, steps by hand not made yet are forgotten."""
        with self._changed:
            if self.paused:
                self.paused, self._requested, self._due = False, 0, None
                self._changed.notify_all()

    def request(self, steps):
        """Pause, and make ``steps`` steps without waiting for wall time; return the number of the last of them."""
        with self._changed:
            self.paused = True
            self._requested += steps
            self._changed.notify_all()
            return self.steps + self._requested

    def close(self):
        """Let ``wait`` return None from now on."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def wait(self, longest=LONGEST_SLEEP):
        """Wait until a step is due and begin it: ``steps`` counts up.

        Return the wall time [s] that was too late to be made up for and given up, nearly always 0.0; None when there
        is no step after ``longest`` [s], in a pause or at a slow rate, and once closed.
        """
        if self._due is None:
            self._due = self._monotonic() + self._period
        if self.standing:
            with self._changed:
                self._changed.wait_for(lambda: not self.paused or self._requested or self._closed, longest)
            return self._by_hand()
        if self._requested:
            return self._by_hand()
        wait = max(self._due, self._last + self._closest) - self._monotonic()
        if wait > 0.0:
            self._sleep(min(wait, longest))
            if wait > longest or self.paused:
                return None
        return None if self._closed else self._begin()

    def _by_hand(self):
        with self._changed:
            if self._closed or not self._requested:
                return None
            self._requested -= 1
            self.steps += 1
            return 0.0

    def _begin(self):
        """Begin a step that is due; say when the next one is."""
        self.steps += 1
        self._last = now = self._monotonic()
        late = now - self._due
        if not self._period:
            self._due = now
            return 0.0
        if late > self._longest_catch_up:
            self._due = now + self._period
            return late
        self._due += self._period
        return 0.0
