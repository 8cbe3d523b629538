"""Threads and timers that log errors and continue.

A thread that fails ends silently: the node looks healthy but no longer does its work.
"""
import functools
import threading
import time
import traceback
from typing import Any, Callable

import rospy

from rospy_support import rospy_internals
from rospy_support.throttle import WallThrottle

PAUSE = 1.0  # [s] of wall time after an error, before a loop starts again
REMINDER = 10.0  # [s] of wall time between two reports of the same error


def keep_running(name: str, loop: Callable[[], Any]) -> threading.Thread:
    """Call ``loop()`` in a daemon thread of this name, again after each error, until it returns; return the thread."""
    returned = guarded(lambda: loop() or True)

    def run() -> None:
        while not returned():
            if rospy_internals.shutting_down():
                return
            time.sleep(PAUSE)
    thread = threading.Thread(target=run, name=name, daemon=True)
    thread.start()
    return thread


def call_every(period: float, function: Callable[[rospy.timer.TimerEvent], Any]) -> rospy.Timer:
    """Call ``function(event)`` every ``period`` [s] of ROS time, as rospy.Timer does, also after errors and jumps."""
    return rospy.Timer(rospy.Duration.from_sec(period), guarded(function), reset=True)


def guarded(function: Callable[..., Any]) -> Callable[..., Any]:
    """Wrap a function, so that it logs an error instead of raising it, and then returns None.

    While the node shuts down, errors are ignored: rospy is closing topics and services.
    """
    throttle = WallThrottle(REMINDER)

    @functools.wraps(function)
    def call(*arguments: Any) -> Any:
        try:
            return function(*arguments)
        except Exception as error:
            text = f'{type(error).__name__}: {error}'
            if not rospy_internals.shutting_down() and throttle.due(text=text, changed=0.0):
                rospy.logerr('An error in this node, which continues; please report it:\n%s', traceback.format_exc())
            return None
    return call
