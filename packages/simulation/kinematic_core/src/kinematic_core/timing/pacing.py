"""Compute when the next step of a simulator is due: in real time, faster, slower, or on request.

Simulated time is counted in steps, never measured: step number n ends at BEGIN + n * step, whatever the wall clock
does.

There are two policies for steps that are late because the machine was busy:

* All other nodes use wall time (``bounded`` false): late steps are caught up at FASTER times the pace, so that
  simulated time does not fall behind. They are not made in one burst: after a stall of the whole machine, a robot would
  drive without control, and its watchdog would stop it, before a node could react.
* The simulator publishes its time, and all other nodes follow it (``bounded`` true): if it caught up quickly, the nodes
  could not follow. So late steps are caught up at FASTER_BOUNDED times the pace, and a backlog of more than
  MAX_BOUNDED_CATCH_UP is dropped.

Threading contract: one thread calls ``wait`` and makes each step between two calls; all other methods may be called
from any thread. One lock guards all shared data.
"""
import collections
import math
import threading
import time
from typing import Callable, Deque, Optional

BEGIN = 1_000_000_000  # [ns] simulated time before the first step; in ROS, 0 means that there is no time yet
MAX_CATCH_UP = 5.0  # [s] of wall time that is caught up; a longer gap means that the machine was suspended
MAX_BOUNDED_CATCH_UP = 0.5  # [s] the same if other nodes follow
MAX_SLEEP = 0.1  # [s] of wall time after which ``wait`` returns at the latest
FASTER = 3.0  # times the pace for late steps: low enough for commands at 10 Hz and a watchdog of 0.5 s
FASTER_BOUNDED = 1.25  # the same if other nodes follow


class StepRequest:
    """Requested steps (none or more); returned by ``pause`` and ``request``.

    ``last`` is the number of the last of them. ``made`` is None while they are not done, then True, or False if they
    were dropped because of ``resume`` or ``close``.
    """

    def __init__(self, steps: int, last: int) -> None:
        self.steps, self.last = steps, last
        self.made: Optional[bool] = None
        self._answered = threading.Event()

    def wait(self, longest: float) -> bool:
        """Wait for the answer, at most ``longest`` [s] of wall time; return whether there is one."""
        return self._answered.wait(longest)

    def answer(self, made: bool) -> None:
        """Set the answer."""
        self.made = made
        self._answered.set()


class Pacer:
    """Waits for the steps of one simulator."""

    def __init__(self, step: float, rate: float = 1.0, bounded: bool = False, *, paused: bool = False,
                 monotonic: Callable[[], float] = time.monotonic,
                 sleep: Optional[Callable[[float], object]] = None) -> None:
        """``step`` [s] of simulated time; ``rate``: simulated seconds per wall-clock second, math.inf: never wait.

        ``monotonic`` [s] is the wall clock; ``sleep`` waits in it, until something has changed or so many seconds
        have passed.
        """
        self.step = step
        self._lock = threading.RLock()
        self._changed = threading.Condition(self._lock)
        self._monotonic = monotonic
        self._sleep: Callable[[float], object] = sleep or self._changed.wait
        self._steps = 0  # steps started so far
        self._stepping = False  # whether the last of them is still being made
        self._requested = 0  # requested steps that are not yet made
        self._requests: Deque[StepRequest] = collections.deque()  # unanswered, in the order of their steps
        self._closed = self._woken = False
        self._due = math.nan  # [s] wall time of the next step, from the first wait on; in a pause, as it was before
        self._last = -math.inf  # [s] wall time of the last one
        self._paused = paused
        self._paused_at = math.nan  # [s] wall time of the start of the pause, if there is one
        self._set_pace(rate, bounded)

    def set_rate(self, rate: float, bounded: bool) -> None:
        """Make steps at a rate from now on, in one of the two policies; late steps are not caught up."""
        with self._lock:
            self._set_pace(rate, bounded)
            self._due = (self._paused_at if self._paused else self._monotonic()) + self._period
            self.wake()

    def _set_pace(self, rate: float, bounded: bool) -> None:
        self._rate, self._period = rate, self.step / rate  # [s] of wall time; 0 at math.inf
        self._closest = self._period / (FASTER_BOUNDED if bounded else FASTER)
        self._longest_catch_up = MAX_BOUNDED_CATCH_UP if bounded else MAX_CATCH_UP

    @property
    def rate(self) -> float:
        """Return the requested simulated seconds per wall-clock second."""
        return self._rate

    @property
    def paused(self) -> bool:
        """Return whether steps are made only on request."""
        return self._paused

    @property
    def steps(self) -> int:
        """Return how many steps have started."""
        return self._steps

    @property
    def nanoseconds(self) -> int:
        """Return the simulated time [ns] at the end of the step that started last."""
        return self.nanoseconds_after(self._steps)

    def nanoseconds_after(self, steps: int) -> int:
        """Return the simulated time [ns] after a number of steps."""
        return BEGIN + steps * round(self.step * 1e9)

    def pause(self) -> StepRequest:
        """Stop stepping until ``resume``, except for steps of ``request``; return a StepRequest of no steps.

        It is answered when no step is being made and all earlier requests are done.
        """
        return self.request(0)

    def request(self, steps: int) -> StepRequest:
        """Pause, and make ``steps`` steps without waiting for wall time; return their StepRequest."""
        with self._lock:
            if not self._paused:
                self._paused, self._paused_at = True, self._monotonic()
            self._requested += steps
            request = StepRequest(steps, self._steps + self._requested)
            self._requests.append(request)
            self._answer_requests()
            self.wake()
            return request

    def resume(self) -> int:
        """Continue from here; the pause is not caught up, and requested steps that have not started are dropped.

        Return how many steps have started until then.
        """
        with self._lock:
            if self._paused:
                self._due += self._monotonic() - self._paused_at
                self._paused, self._requested = False, 0
                while self._requests and (self._requests[-1].last > self._steps or not self._requests[-1].steps):
                    self._requests.pop().answer(False)
                self.wake()
            return self._steps

    def wake(self) -> None:
        """Let ``wait`` return immediately: the current call, or else the next one."""
        with self._lock:
            self._woken = True
            self._changed.notify_all()

    def close(self) -> None:
        """Let ``wait`` return None from now on; drop requested steps."""
        with self._lock:
            self._closed = True
            self._answer_requests()
            self.wake()

    def wait(self, longest: float = MAX_SLEEP) -> Optional[float]:
        """Wait until a step is due and start it: ``steps`` counts up. The previous step counts as done now.

        Return the wall time [s] that was dropped because it is too long to catch up, nearly always 0.0. Return None if
        no step is due after ``longest`` [s], in a pause or at a slow rate, and when woken or closed.
        """
        with self._lock:
            self._stepping = False
            self._answer_requests()
            now = self._monotonic()
            end = now + longest
            if math.isnan(self._due):
                self._due, self._paused_at = now + self._period, now
            try:
                while not self._closed:
                    if self._requested:
                        self._requested -= 1
                        return self._begin()
                    due = math.inf if self._paused else max(self._due, self._last + self._closest)
                    if now >= due:
                        return self._begin_due(now)
                    if self._woken or now >= end:
                        return None
                    self._sleep(min(due, end) - now)
                    now = self._monotonic()
                return None
            finally:
                self._woken = False

    def _begin(self, given_up: float = 0.0) -> float:
        self._steps += 1
        self._stepping = True
        return given_up

    def _begin_due(self, now: float) -> float:
        """Start a step that is due, and compute when the next one is."""
        late, self._last = now - self._due, now
        if not self._period:
            self._due = now
        elif late > self._longest_catch_up:
            self._due = now + self._period
            return self._begin(given_up=late)
        else:
            self._due += self._period
        return self._begin()

    def _answer_requests(self) -> None:
        while self._requests and (self._closed or self._requests[0].last <= self._steps - self._stepping):
            self._requests.popleft().answer(not self._closed)
