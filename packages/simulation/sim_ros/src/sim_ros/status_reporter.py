"""Publish ``~clock_status``: how a simulator's time passes."""
import math
import time

from rospy_support.topics import Publisher
from sim_ros.msg import ClockStatus

PERIOD = 1.0  # [s] of wall time between two messages
ENOUGH = 0.9  # a smaller share of the requested rate causes a warning
WINDOW = 5  # periods in which it has to be smaller; a short stall is caught up, and needs no warning


class StatusReporter:
    """Publishes the status every PERIOD, and at once when something has changed. One thread uses it."""

    def __init__(self, pacer, lockstep, throttle, followed):
        """``pacer`` is the simulator's; ``lockstep``: whether it waits for nodes; ``throttle`` is for the warning.

        ``followed``: whether the other nodes use the simulator's time.
        """
        self._pacer = pacer
        self._lockstep = lockstep
        self._throttle = throttle
        self._followed = followed
        self._publisher = Publisher('~clock_status', ClockStatus, queue_size=10, latch=True)
        self.topic = self._publisher.resolved_name
        self._next = 0.0  # [s, monotonic] when the next message is due if nothing changes
        self._reported = None  # (paused, rate, whether a step was late) of the last message
        self._since = time.monotonic()  # [s] of the last message
        self._steps = 0  # steps at the last message
        self._slow = []  # the paces of the last messages, all too slow

    def report(self, late, busy):
        """Publish the status if it is due; ``late`` and ``busy``: late_steps and busy of ClockStatus."""
        now, pacer = time.monotonic(), self._pacer
        state = pacer.paused, pacer.rate, late > 0
        changed = state != self._reported
        if not changed and now < self._next:
            return
        passed = now - self._since
        pace = (pacer.steps - self._steps) * pacer.step / max(passed, 1e-9)
        if not changed and passed >= PERIOD:
            self._check(pace)
        self._since, self._steps = now, pacer.steps
        self._next, self._reported = now + PERIOD, state
        self._publisher.publish(pacer.steps, pacer.nanoseconds / 1e9, pacer.rate, pace, pacer.paused, self._lockstep,
                                late, busy)

    def _check(self, pace):
        """Warn that time passes too slowly, if ~rate asks for a rate and no node is the cause."""
        rate = self._pacer.rate
        slow = pace < ENOUGH * rate and not self._pacer.paused and not self._lockstep and rate < math.inf
        self._slow = [*self._slow, pace][-WINDOW:] if slow else []
        if len(self._slow) == WINDOW:
            self._throttle.warn('slow', 'Time passes %.1f times as fast as the wall clock, although ~rate is %g: this '
                                'machine is too slow, or too busy. %s', sum(self._slow) / WINDOW, rate,
                                'This does not change what nodes that follow /clock do.' if self._followed else
                                'Nodes wait by the wall clock, so what they drive by time becomes too short.')
