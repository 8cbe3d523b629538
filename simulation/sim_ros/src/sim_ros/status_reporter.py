"""Publish ``~clock_status``: how a simulator's time passes."""
import math
import time

from rospy_support.topics import Publisher
from sim_ros.msg import ClockStatus

PERIOD = 1.0  # [s] of wall time between two messages
ENOUGH = 0.9  # a smaller share of the requested rate causes a warning


class StatusReporter:
    """Publishes the status when something has changed and, if ``periodic``, every PERIOD. One thread uses it."""

    def __init__(self, pacer, lockstep, periodic, throttle):
        """``pacer`` is the simulator's; ``lockstep``: whether it waits for nodes; ``throttle`` is for the warning."""
        self._pacer = pacer
        self._lockstep = lockstep
        self._periodic = periodic
        self._throttle = throttle
        self._publisher = Publisher('~clock_status', ClockStatus, queue_size=10, latch=True)
        self.topic = self._publisher.resolved_name
        self._next = 0.0  # [s, monotonic] when the next message is due if nothing changes
        self._reported = None  # (paused, rate, whether a step was late) of the last message
        self._since = time.monotonic()  # [s] of the last message
        self._steps = 0  # steps at the last message

    def report(self, late, busy):
        """Publish the status if it is due; ``late`` and ``busy``: late_steps and busy of ClockStatus."""
        now, pacer = time.monotonic(), self._pacer
        state = pacer.paused, pacer.rate, late > 0
        changed = state != self._reported
        if not changed and not (self._periodic and now >= self._next):
            return
        passed = now - self._since
        pace = (pacer.steps - self._steps) * pacer.step / max(passed, 1e-9)
        if not changed and passed >= PERIOD and pace < ENOUGH * pacer.rate:  # nothing else has changed
            self._warn_of_pace(pace)
        self._since, self._steps = now, pacer.steps
        self._next, self._reported = now + PERIOD, state
        self._publisher.publish(pacer.steps, pacer.nanoseconds / 1e9, pacer.rate, pace, pacer.paused, self._lockstep,
                                late, busy)

    def _warn_of_pace(self, pace):
        """Warn that time passes too slowly, if ~rate asks for a rate and no node is the cause."""
        if not self._pacer.paused and not self._lockstep and self._pacer.rate < math.inf:
            self._throttle.warn('slow', 'Time passes %.1f times as fast as the wall clock, although ~rate is %g. This '
                                'does not change what nodes that follow /clock do.', pace, self._pacer.rate)
